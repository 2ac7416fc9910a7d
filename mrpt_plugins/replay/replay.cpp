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

constexpr const char* kOdometryNoise = "reader.odometry_sigma_factor";
constexpr int kMostMeasurements = 4;  // of the noise, each with a map

/// The number that section.key of a configuration is; 1 where it has none.
double setting(const IniFile::Settings& configuration, const std::string& name) {
  for (const auto& [section, keys] : configuration) {
    for (const auto& [key, value] : keys) {
      if (section + "." + key == name) return std::stod(value);
    }
  }
  return 1;
}

/// Settings that a map is made again with.
struct Remedies {
  bool calibrates = false;  ///< scale and drift of the odometry are estimated
  bool calibration_was_tried = false;
  std::map<std::string, double> factors;  ///< of noise, by key
};

/// Whether odometry is less sure than stated, which an error of its scale and a drift make.
bool may_be_calibrated(const HealthEntry& entry) {
  return entry.scale == kOdometryNoise && entry.value > 1;
}

/// Adds what a bad map says of its own settings: what may mend them, or else factors of noise.
/// Returns whether anything changed.
bool add_remedies(const Health& health, const IniFile::Settings& configuration, Remedies& out) {
  bool changed = false;
  for (const HealthEntry& entry : health) {
    if (entry.verdict != HealthVerdict::kBad) continue;
    if (may_be_calibrated(entry) && !out.calibration_was_tried) {
      out.calibrates = out.calibration_was_tried = changed = true;
    } else if (!entry.scale.empty()) {
      out.factors.try_emplace(entry.scale, setting(configuration, entry.scale)).first->second *=
          entry.value;
      changed = true;
    }
  }
  return changed;
}

ReplayRequest request_with(const ReplayRequest& request, const Remedies& remedies) {
  ReplayRequest out = request;
  out.settings.emplace_back("sensor.noise=measured");
  if (remedies.calibrates) out.settings.emplace_back("calibration.odometry=yes");
  for (const auto& [key, factor] : remedies.factors) {
    out.settings.push_back(fmt::format("{}={}", key, factor));
  }
  return out;
}

/// Maps logs whose map is bad again, with what they and that map tell of their noise, and takes an
/// outcome that is better. A map in doubt is made again where sign, clock or mounting of a sensor,
/// or what ids are, is not as stated.
void map_as_measured(const ReplayRequest& request, const Watchers& watchers,
                     std::chrono::steady_clock::time_point start, ReplayOutcome& outcome) {
  Health health = outcome.summary.health;
  const IniFile::Settings configuration = outcome.summary.provenance.configuration;
  const bool in_doubt = worst(health) == HealthVerdict::kDoubtful;
  Remedies remedies;
  for (int round = 0; round < kMostMeasurements; ++round) {
    const auto factors = remedies.factors;
    const bool changed = add_remedies(health, configuration, remedies);
    const bool again =
        worst(health) == HealthVerdict::kBad ? round == 0 || changed : in_doubt && round == 0;
    if (!again) return;
    Attempt next = attempt(request_with(request, remedies), watchers, start,
                           {&outcome.summary.health, !changed, in_doubt});
    if (!next.is_written && next.outcome.signal != 0) {
      outcome.signal = next.outcome.signal;
      return;
    }
    const Health& made = next.outcome.summary.health;
    const bool calibrated_in_vain =
        remedies.calibrates && (!next.is_written || worst(made) == HealthVerdict::kBad);
    if (calibrated_in_vain) {  // what the map before says holds still
      remedies.calibrates = false;
      remedies.factors = factors;
    } else {
      health = made;
    }
    if (next.is_written) outcome = std::move(next.outcome);
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
