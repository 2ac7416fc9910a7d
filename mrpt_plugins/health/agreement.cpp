// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/health/agreement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace hybrid {
namespace {

constexpr const char* kName = "agreement over time";
/// The ratio of a right path is 1, but where sensors err in the same way for minutes, or things
/// that stood still for seconds move.
constexpr double kDoubtful = 0.97, kBad = 0.9;
/// A ratio that is less sure does not tell a right path from one that is metres off.
constexpr double kMostSigma = 0.2;

HealthEntry empty_entry(const char* name) {
  HealthEntry entry;
  entry.name = name;
  entry.value = std::numeric_limits<double>::quiet_NaN();
  entry.least = kDoubtful;
  entry.most = std::numeric_limits<double>::infinity();
  entry.verdict = HealthVerdict::kNotJudged;
  return entry;
}

/// Of what was measured in a stretch of the log, at so many places, a right path finds at least
/// this much again late. One that is wrong for a minute loses a small part of all looks.
constexpr double kDip = 0.5;
constexpr std::size_t kPlacesOfDip = 5;

/// The stretch in which the least is found again, if that is less than a right path finds.
const Agreement::Stretch* find_dip(const Agreement& found) {
  const Agreement::Stretch* worst = nullptr;
  for (const Agreement::Stretch& stretch : found.stretches) {
    if (stretch.places < kPlacesOfDip || stretch.ratio >= kDip) continue;
    if (worst == nullptr || stretch.ratio < worst->ratio) worst = &stretch;
  }
  return worst;
}

/// How the late share compares with the soon one.
std::string comparison(const Agreement& found) {
  const bool holds = found.soon >= Agreement::kLeastSoon;
  return fmt::format("{:.2f} +- {:.2f} of {}.", found.ratio, found.sigma,
                     holds ? "it" : "the 10 % that a path has which is right for seconds");
}

/// When the stretch of the log began where the path is the least right: a dip, or that with the
/// most looks that did not agree [s].
double begin_of_worst(const Agreement& found) {
  if (const Agreement::Stretch* dip = find_dip(found); dip != nullptr) return dip->time;
  const auto lost = [](const Agreement::Stretch& s) { return double(s.looks) * (1 - s.ratio); };
  return std::max_element(found.stretches.begin(), found.stretches.end(),
                          [&](const auto& a, const auto& b) { return lost(a) < lost(b); })
      ->time;
}

HealthEntry judged_agreement(const char* name, const Agreement& found) {
  HealthEntry entry = empty_entry(name);
  entry.value = found.ratio;
  entry.least = std::max(0.0, kDoubtful - found.sigma);
  const double at_best = found.ratio + found.sigma;
  entry.verdict = HealthVerdict::kGood;
  if (at_best < kDoubtful) entry.verdict = HealthVerdict::kDoubtful;
  if (at_best < kBad) entry.verdict = HealthVerdict::kBad;
  if (entry.verdict != HealthVerdict::kBad && found.sigma > kMostSigma) {
    entry.verdict = HealthVerdict::kNotJudged;
    entry.value = std::numeric_limits<double>::quiet_NaN();
  }
  for (const Agreement::Stretch& stretch : found.stretches) {
    entry.over_time.push_back({stretch.time, stretch.ratio, double(stretch.looks)});
  }
  return entry;
}

HealthEntry entry_of(const std::string& what, const Agreement& found) {
  HealthEntry entry = judged_agreement(kName, found);
  entry.sentence = fmt::format(
      "{} found {:.0f} % of what had been measured {:.0f} s or more apart at the places in view, "
      "and {:.0f} % of what had been measured seconds apart: {}",
      what, 100 * found.late, found.far_from, 100 * found.soon, comparison(found));
  if (entry.verdict == HealthVerdict::kNotJudged) entry.sentence += " That is too unsure.";
  if (const Agreement::Stretch* dip = find_dip(found); dip != nullptr) {
    if (entry.verdict == HealthVerdict::kGood) entry.verdict = HealthVerdict::kDoubtful;
    entry.sentence += fmt::format(
        " Of {} places that were measured in the 20 s after second {:.0f} only {:.2f} times as "
        "much "
        "was found again.",
        dip->places, dip->time - found.stretches.front().time, dip->ratio);
  }
  if (entry.verdict > HealthVerdict::kGood) {
    entry.knob = fmt::format(
        "the path, which is the least right {:.0f} s after its first such stretch began; other "
        "checks may tell why",
        begin_of_worst(found) - found.stretches.front().time);
  }
  return entry;
}

}  // namespace

std::optional<HealthEntry> map_agreement_health(const Agreement& with_map) {
  if (!std::isfinite(with_map.sigma) || with_map.looks == 0) return std::nullopt;
  HealthEntry entry = judged_agreement("agreement with the map", with_map);
  entry.sentence = fmt::format(
      "Of what the map has in view {:.0f} % was found, and {:.0f} % of what had been measured "
      "seconds apart: {}",
      100 * with_map.late, 100 * with_map.soon, comparison(with_map));
  if (entry.verdict > HealthVerdict::kGood) {
    entry.knob =
        "what was moved or built since the map was made, and errors of the map; the "
        "place where the robot was found ([map] start)";
  }
  return entry;
}

Health agreement_health(const Agreement& detections, const Agreement& scans,
                        const Agreement& clouds) {
  Health health;
  if (std::isfinite(detections.sigma) && detections.looks > 0) {
    health.push_back(entry_of("Detections", detections));
  }
  if (std::isfinite(scans.sigma) && scans.looks > 0) health.push_back(entry_of("Scans", scans));
  if (std::isfinite(clouds.sigma) && clouds.looks > 0) {
    health.push_back(entry_of("Clouds", clouds));
  }
  if (!health.empty()) return health;
  HealthEntry entry = empty_entry(kName);
  entry.sentence = "Too little was in view again much later to tell whether the path is right.";
  return {entry};
}

HealthEntry closure_agreement_health(const ClosureAgreement& found, const std::string& rival) {
  if (found.agreeing + found.rivals == 0) {
    HealthEntry entry = empty_entry(kName);
    entry.sentence = "No closure is checked by others, to tell whether the path is right.";
    return entry;
  }
  Agreement counted;  // of all passages, so that it has no sigma
  counted.ratio = found.ratio;
  for (const ClosureAgreement::Stretch& stretch : found.stretches) {
    counted.stretches.push_back({double(stretch.first), stretch.ratio, stretch.passages});
  }
  HealthEntry entry = judged_agreement(kName, counted);
  entry.sentence = fmt::format(
      "Of what was seen again in {} passages the map, without it, predicts {}. In {} others, "
      "closures of different times agree with each other and not with the map.",
      found.agreeing + found.rivals + found.alone, found.agreeing, found.rivals);
  if (entry.verdict != HealthVerdict::kGood) {
    entry.knob = fmt::format(
        "closure {}, which others agree with and the map does not: it may be right; where it is, "
        "--trusted FILE, with it and the odometry",
        rival);
  }
  return entry;
}

std::vector<double> agreement_values(const Health& health) {
  std::vector<double> out;
  for (const HealthEntry& entry : health) {
    if (entry.name == kName) out.push_back(entry.value);
  }
  return out;
}

HealthVerdict agreement_of(const Health& health) {
  HealthVerdict out = HealthVerdict::kGood;
  for (const HealthEntry& entry : health) {
    if (entry.name != kName) continue;
    const bool is_judged = entry.verdict != HealthVerdict::kNotJudged;
    out = std::max(out, is_judged ? entry.verdict : HealthVerdict::kBad);
  }
  return out;
}

}  // namespace hybrid
