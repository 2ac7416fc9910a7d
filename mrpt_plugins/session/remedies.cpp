// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/session/remedies.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

#include "libhybrid/core/infinity.h"
#include "libhybrid/initialization/direction_tracker.h"
#include "libhybrid/io/parse_number.h"
#include "mrpt_plugins/health/agreement.h"
#include "mrpt_plugins/health/fix_figures.h"
#include "mrpt_plugins/session/judgement.h"

namespace hybrid {
namespace {

constexpr const char* kOdometryNoise = "reader.odometry_sigma_factor";
constexpr const char* kCalibrated = "calibration.odometry=yes";
constexpr const char* kAllDetections = "keyframes.tracklets=yes";  // also between keyframes
constexpr const char* kSigma = "detection_sigma_m";                // of BearingRangeAssociation
/// Of landmarks, in sigmas of a detection: in octaves from where that tells nearly all of which
/// landmark it is, up to where it tells next to nothing.
constexpr std::array<double, 3> kExtents{1, 2, 4};

/// Time between keyframes [s]: in octaves from where errors of detections begin to differ, up to
/// where few keyframes are left of a drive past a thing.
constexpr std::array<double, 3> kIntervals{0.5, 1, 2};

/// By how much more must agree in one of two maps that are not both good, so that this tells which
/// is the better one: the usual sigma of a share.
constexpr double kClearly = 0.05;

/// As long as odometry tells where a thing must be [s]: what AgreementOptions calls soon.
constexpr double kLongMemory = 20;
constexpr const char* kMemory = "BearingRangeAssociation.memory";
constexpr const char* kRangeSigma = "BearingRangeAssociation.range_sigma";

/// The least of the agreements over time of a map, 0 where none is judged.
double least_agreement(const Health& health) {
  double least = kInfinity;
  for (const double value : agreement_values(health)) least = std::min(least, value);
  return std::isfinite(least) ? least : 0;
}

/// Whether the agreement over time of a map was judged.
bool is_judged(const Health& health) {
  const std::vector<double> values = agreement_values(health);
  return std::any_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

/// Whether what a map has and others may lack is not credible: a calibration, fixes.
bool has_bad_option(const Health& health) {
  return std::any_of(health.begin(), health.end(), [](const HealthEntry& entry) {
    return entry.is_optional && entry.verdict == HealthVerdict::kBad;
  });
}

/// Whether a map whose agreement is not judged is right by its other checks, of which there are as
/// many as of another map.
bool is_right_without(const Health& a, const Health& other) {
  const auto others = [](const Health& health) {
    const std::vector<double> agreement = agreement_values(health);
    return count_judged(health) - std::count_if(agreement.begin(), agreement.end(),
                                                [](double value) { return std::isfinite(value); });
  };
  return worst(a) < HealthVerdict::kBad && others(a) > 0 && others(a) >= others(other);
}

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
  double value = 1;
  parse_number(text_of(configuration, name), value);
  return value;
}

/// Adds section.key=value in place of another value of that key.
void give(ReplayRequest& request, const std::string& setting) {
  const std::string key = setting.substr(0, setting.find('=') + 1);
  std::vector<std::string>& all = request.settings;
  const auto has_key = [&](const std::string& other) { return other.rfind(key, 0) == 0; };
  all.erase(std::remove_if(all.begin(), all.end(), has_key), all.end());
  all.push_back(setting);
}

/// Whether odometry is less sure than stated, which an error of its scale and a drift make.
bool may_be_calibrated(const HealthEntry& entry) {
  return entry.scale == kOdometryNoise && entry.value > 1;
}

/// The usual sigma of where a detection of a map puts its landmark [m], if it was left open how
/// detections find their landmarks; else none.
std::optional<double> sigma_to_coarsen(const Summary& summary) {
  const auto sigma = summary.statistics.find(kSigma);
  const IniFile::Settings& configuration = summary.provenance.configuration;
  const bool is_free = text_of(configuration, "BearingRangeAssociation.method") == "hypotheses" &&
                       text_of(configuration, "BearingRangeAssociation.extent") == "0";
  if (sigma == summary.statistics.end() || !is_free) return std::nullopt;
  return sigma->second;
}

bool has_directions(const Summary& summary) {
  return summary.statistics.count("directions") != 0;
}

/// The request with scale and drift of the odometry estimated, unless the map had that.
std::vector<ReplayRequest> calibrated(const ReplayRequest& request, const Summary& summary) {
  const IniFile::Settings& configuration = summary.provenance.configuration;
  const bool is_free = summary.statistics.count(kSigma) != 0 &&
                       text_of(configuration, "calibration.odometry") == "false";
  if (!is_free) return {};
  ReplayRequest out = request;
  give(out, kCalibrated);
  return {out};
}

std::vector<ReplayRequest> coarser(const ReplayRequest& request, const Summary& summary) {
  std::vector<ReplayRequest> out;
  const std::optional<double> sigma = sigma_to_coarsen(summary);
  for (const double extent : kExtents) {
    if (!sigma) break;
    out.push_back(request);
    give(out.back(), "BearingRangeAssociation.method=jcbb");
    give(out.back(), fmt::format("BearingRangeAssociation.extent={:.3g}", extent * *sigma));
    give(out.back(), kAllDetections);
  }
  return out;
}

std::vector<ReplayRequest> following_longer(const ReplayRequest& request, const Summary& summary) {
  const IniFile::Settings& configuration = summary.provenance.configuration;
  const DirectionTrackerOptions usual;
  const bool is_free = has_directions(summary) && setting(configuration, kMemory) == usual.memory &&
                       setting(configuration, kRangeSigma) == usual.range_sigma;
  if (!is_free) return {};
  std::vector<ReplayRequest> out(2, request);
  for (ReplayRequest& longer : out) give(longer, fmt::format("{}={}", kMemory, kLongMemory));
  give(out.back(), fmt::format("{}={}", kRangeSigma, usual.range_sigma / 2));
  return out;
}

std::vector<ReplayRequest> sparser(const ReplayRequest& request, const Summary& summary) {
  std::vector<ReplayRequest> out;
  const IniFile::Settings& configuration = summary.provenance.configuration;
  const bool is_free = setting(configuration, "keyframes.min_time") == 0 &&
                       summary.statistics.count(kSigma) != 0 && !has_directions(summary);
  for (const double interval : kIntervals) {
    if (!is_free) break;
    out.push_back(Remedies().apply(request));
    give(out.back(), fmt::format("keyframes.min_time={}", interval));
  }
  return out;
}

}  // namespace

bool Remedies::add(const Health& health, const IniFile::Settings& configuration) {
  bool changed = false;
  for (const HealthEntry& entry : health) {
    if (entry.verdict != HealthVerdict::kBad) continue;
    if (may_be_calibrated(entry) && !calibration_was_tried) {
      calibrates = calibration_was_tried = changed = true;
    } else if (!entry.scale.empty()) {
      factors.try_emplace(entry.scale, setting(configuration, entry.scale)).first->second *=
          entry.value;
      changed = true;
    }
  }
  return changed;
}

ReplayRequest Remedies::apply(ReplayRequest request) const {
  request.settings.emplace_back(kMeasuresNoise);
  if (calibrates) request.settings.emplace_back(kCalibrated);
  for (const auto& [key, factor] : factors) {
    request.settings.push_back(fmt::format("{}={}", key, factor));
  }
  return request;
}

std::vector<ReplayRequest> draws(const ReplayRequest& request, std::vector<ReplayRequest> bases,
                                 const Summary& summary) {
  std::vector<ReplayRequest> out = following_longer(request, summary);
  // Associations that may have been wrong have told what the maps that were taken have beside what
  // was measured, and one that was too fine may have been worse for that.
  bases.push_back(Remedies().apply(request));
  for (const ReplayRequest& given : bases) {
    for (ReplayRequest& other : calibrated(given, summary)) out.push_back(std::move(other));
  }
  for (const ReplayRequest& given : bases) {
    for (ReplayRequest& coarse : coarser(given, summary)) out.push_back(std::move(coarse));
  }
  for (ReplayRequest& sparse : sparser(request, summary)) out.push_back(std::move(sparse));
  return out;
}

std::optional<ReplayRequest> with_stated_noise(ReplayRequest request, const Summary& summary) {
  if (verdict_on_fixes(summary.fixes) != HealthVerdict::kBad) return std::nullopt;
  give(request, "sensor.noise=stated");
  return request;
}

std::optional<ReplayRequest> without_fixes(ReplayRequest request, const Summary& summary) {
  const bool agrees =
      !is_judged(summary.health) || agreement_of(summary.health) == HealthVerdict::kGood;
  const bool are_bad = verdict_on_fixes(summary.fixes) == HealthVerdict::kBad;
  if (summary.fixes.used == 0 || (agrees && !are_bad)) return std::nullopt;
  const std::string chosen = fmt::format("{}", fmt::join(summary.chosen_plugins, " "));
  std::istringstream names(
      chosen.empty() ? text_of(summary.provenance.configuration, "plugins.classes") : chosen);
  std::string others;
  for (std::string name; names >> name;) {
    if (name != "Fixes") others += (others.empty() ? "" : " ") + name;
  }
  if (others.empty()) return std::nullopt;
  request.settings.push_back("plugins.classes=" + others);
  return request;
}

bool agrees_better(const Health& a, const Health& b) {
  if (has_bad_option(a) && !has_bad_option(b)) return false;
  const bool a_is_judged = is_judged(a), b_is_judged = is_judged(b);
  const HealthVerdict of_a = agreement_of(a), of_b = agreement_of(b);
  if (!a_is_judged && b_is_judged && of_b == HealthVerdict::kBad) return is_right_without(a, b);
  if (a_is_judged && !b_is_judged && of_a == HealthVerdict::kBad) return !is_right_without(b, a);
  if (a_is_judged != b_is_judged) return of_a < of_b;
  const bool both_are_good = of_a == HealthVerdict::kGood && of_b == HealthVerdict::kGood;
  const double gain = least_agreement(a) - least_agreement(b);
  if (!both_are_good && std::abs(gain) > kClearly) return gain > 0;
  if (gain <= 0 && worst(b) < HealthVerdict::kBad) return false;
  if (is_better(a, b) || is_better(b, a)) return is_better(a, b);
  return of_a < of_b;
}

}  // namespace hybrid
