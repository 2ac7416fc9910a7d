// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <map>
#include <optional>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/replay/detail/attempt.h"

namespace hybrid {
namespace {

constexpr const char* kOdometryNoise = "reader.odometry_sigma_factor";
constexpr int kMostMeasurements = 4;                 // of the noise, each with a map
constexpr const char* kSigma = "detection_sigma_m";  // of BearingRangeAssociation
constexpr const char* kFoundAgain = "landmarks seen at one time only";
constexpr const char* kCopies = "copies of landmarks";
/// Of landmarks, in sigmas of a detection: in octaves from where that tells nearly all of which
/// landmark it is, up to where it tells next to nothing.
constexpr std::array<double, 3> kExtents{1, 2, 4};

/// What section.key of a configuration is; empty where it has none.
std::string text_of(const IniFile::Settings& configuration, const std::string& name) {
  for (const auto& [section, keys] : configuration) {
    for (const auto& [key, value] : keys) {
      if (section + "." + key == name) return value;
    }
  }
  return {};
}

/// The number that section.key of a configuration is; 1 where it has none.
double setting(const IniFile::Settings& configuration, const std::string& name) {
  const std::string text = text_of(configuration, name);
  return text.empty() ? 1 : std::stod(text);
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

/// The entry of a check; none where it was not made.
const HealthEntry* find_entry(const Health& health, const std::string& name) {
  const auto it = std::find_if(health.begin(), health.end(),
                               [&](const HealthEntry& entry) { return entry.name == name; });
  return it == health.end() ? nullptr : &*it;
}

/// How far a check is from where it begins to be in doubt, a factor; 0: it was not made.
double excess(const Health& health, const char* check) {
  const HealthEntry* entry = find_entry(health, check);
  return entry == nullptr ? 0 : entry->value / entry->most;
}

bool is_bad(const Health& health, const char* check) {
  const HealthEntry* entry = find_entry(health, check);
  return entry != nullptr && entry->verdict == HealthVerdict::kBad;
}

/// The check that calls a map bad because its landmarks were decided finer than could be told; none
/// if there is none. Landmarks that are near each other may look like copies of each other, so that
/// these count where all are found again.
const char* too_fine(const Health& health) {
  for (const char* check : {kFoundAgain, kCopies}) {
    if (is_bad(health, check)) return check;
  }
  return nullptr;
}

/// Whether map `a` is better by a check than map `b`, and so good that it is not bad, nor are its
/// landmarks lost: of two bad maps, neither is to be believed.
bool is_better_by(const char* check, const Health& a, const Health& b) {
  const bool made = find_entry(a, kFoundAgain) != nullptr && find_entry(a, check) != nullptr;
  return made && !is_bad(a, kFoundAgain) && !is_bad(a, check) &&
         excess(a, check) < excess(b, check);
}

/// The usual sigma of where a detection of a map puts its landmark [m], if it was left open how
/// detections find their landmarks; else none.
std::optional<double> sigma_to_coarsen(const Summary& summary) {
  const auto sigma = summary.statistics.find(kSigma);
  const IniFile::Settings& configuration = summary.provenance.configuration;
  const bool is_free = text_of(configuration, "BearingRangeAssociation.method") == "hypotheses" &&
                       setting(configuration, "BearingRangeAssociation.extent") == 0;
  if (sigma == summary.statistics.end() || !is_free) return std::nullopt;
  return sigma->second;
}

/// Where landmarks are not found again, or mapped twice, which detection is of which landmark was
/// decided finer than could be told. Landmarks get an extent, and what may be of one of them is of
/// it (joint compatibility, which prefers a landmark that is known to a new one): the least extent
/// with which what was bad is not in doubt any more, or else with which it is least.
void map_coarsely(const ReplayRequest& request, const Watchers& watchers,
                  std::chrono::steady_clock::time_point start, ReplayOutcome& outcome) {
  const char* check = too_fine(outcome.summary.health);
  const std::optional<double> sigma = sigma_to_coarsen(outcome.summary);
  if (check == nullptr || !sigma) return;
  const auto better = [check](const Health& a, const Health& b) {
    return is_better_by(check, a, b);
  };
  for (const double extent : kExtents) {
    ReplayRequest coarse = request;
    coarse.settings.emplace_back("BearingRangeAssociation.method=jcbb");
    coarse.settings.push_back(
        fmt::format("BearingRangeAssociation.extent={:.3g}", extent * *sigma));
    Attempt next =
        attempt(coarse, watchers, start, {&outcome.summary.health, better, false, false});
    if (next.outcome.signal != 0) outcome.signal = next.outcome.signal;
    if (next.is_written) outcome = std::move(next.outcome);
    if (outcome.signal != 0 || excess(outcome.summary.health, check) <= 1) return;
  }
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
/// or what ids are, is not as stated. Returns the request of the map that is taken.
ReplayRequest map_as_measured(const ReplayRequest& request, const Watchers& watchers,
                              std::chrono::steady_clock::time_point start, ReplayOutcome& outcome) {
  Health health = outcome.summary.health;
  const IniFile::Settings configuration = outcome.summary.provenance.configuration;
  const bool in_doubt = worst(health) == HealthVerdict::kDoubtful;
  Remedies remedies;
  ReplayRequest taken = request;
  for (int round = 0; round < kMostMeasurements; ++round) {
    const auto factors = remedies.factors;
    const bool changed = add_remedies(health, configuration, remedies);
    const bool again =
        worst(health) == HealthVerdict::kBad ? round == 0 || changed : in_doubt && round == 0;
    if (!again) return taken;
    ReplayRequest measured = request_with(request, remedies);
    Attempt next = attempt(measured, watchers, start,
                           {&outcome.summary.health, is_better, !changed, in_doubt});
    if (!next.is_written && next.outcome.signal != 0) {
      outcome.signal = next.outcome.signal;
      return taken;
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
    if (next.is_written) {
      outcome = std::move(next.outcome);
      taken = std::move(measured);
    }
  }
  return taken;
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
    const ReplayRequest taken = map_as_measured(request, watchers, start, first.outcome);
    if (first.outcome.signal == 0) map_coarsely(taken, watchers, start, first.outcome);
  } catch (const Interrupted& e) {
    first.outcome.signal = e.signal();
  } catch (const Error& e) {
    first.outcome.summary.warnings.push_back(
        fmt::format("the log was not mapped again with its noise measured: {}", e.what()));
  }
  return std::move(first.outcome);
}

}  // namespace hybrid
