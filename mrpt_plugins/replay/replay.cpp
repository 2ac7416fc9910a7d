// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/replay.h"

#include <fmt/format.h>

#include <chrono>
#include <map>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/replay/detail/attempt.h"

namespace hybrid {
namespace {

constexpr int kMostMeasurements = 3;  // of the noise, each with a map

/// The number that section.key of a configuration is; 1 where it has none.
double setting(const IniFile::Settings& configuration, const std::string& name) {
  for (const auto& [section, keys] : configuration) {
    for (const auto& [key, value] : keys) {
      if (section + "." + key == name) return std::stod(value);
    }
  }
  return 1;
}

/// Multiplies the factors of noise by what a bad map says of them; returns whether any changed.
bool scale_noise(const Health& health, const IniFile::Settings& configuration,
                 std::map<std::string, double>& factors) {
  bool changed = false;
  for (const HealthEntry& entry : health) {
    if (entry.verdict != HealthVerdict::kBad || entry.scale.empty()) continue;
    factors.try_emplace(entry.scale, setting(configuration, entry.scale)).first->second *=
        entry.value;
    changed = true;
  }
  return changed;
}

/// Maps logs whose map is bad again, with what they and that map tell of their noise, and takes an
/// outcome that is better.
void map_as_measured(const ReplayRequest& request, const Watchers& watchers,
                     std::chrono::steady_clock::time_point start, ReplayOutcome& outcome) {
  Health health = outcome.summary.health;
  const IniFile::Settings configuration = outcome.summary.provenance.configuration;
  std::map<std::string, double> factors;
  for (int round = 0; round < kMostMeasurements; ++round) {
    const bool scaled = scale_noise(health, configuration, factors);
    if (worst(health) != HealthVerdict::kBad || (round > 0 && !scaled)) return;
    ReplayRequest measured = request;
    measured.settings.emplace_back("sensor.noise=measured");
    for (const auto& [key, factor] : factors) {
      measured.settings.push_back(fmt::format("{}={}", key, factor));
    }
    Attempt next = attempt(measured, watchers, start, {&outcome.summary.health, !scaled});
    health = next.outcome.summary.health;
    if (next.is_written) {
      outcome = std::move(next.outcome);
    } else if (next.outcome.signal != 0) {
      outcome.signal = next.outcome.signal;
      return;
    }
  }
}

}  // namespace

ReplayOutcome replay(const ReplayRequest& request,
                     const std::function<void(const ReplayProgress&)>& progress,
                     const std::function<void(const ReplayOutcome&)>& published) {
  const auto start = std::chrono::steady_clock::now();
  const Watchers watchers{progress, published};
  Attempt first = attempt(request, watchers, start, {});
  if (!first.may_measure) return std::move(first.outcome);
  try {
    map_as_measured(request, watchers, start, first.outcome);
  } catch (const Interrupted& e) {
    first.outcome.signal = e.signal();
  } catch (const Error& e) {
    first.outcome.summary.warnings.push_back(
        fmt::format("the log was not mapped again with its noise measured: {}", e.what()));
  }
  return std::move(first.outcome);
}

}  // namespace hybrid
