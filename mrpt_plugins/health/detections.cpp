// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "mrpt_plugins/health/detail/run_facts.h"

namespace hybrid {
namespace {

constexpr UpperLimits kMovedLimits{0.1, 0.5}, kClutterLimits{0.2, 0.5};
constexpr UpperLimits kNoRangeLimits{0.8, 0.98};
constexpr std::size_t kFewestDetections = 30;
/// Shares of scans. One that agrees with no local map leaves the map in two parts, which a closure
/// may join.
constexpr UpperLimits kSeeNothingLimits{0.2, 0.5}, kAgreeWithNothingLimits{0.01, 0.05};
/// Errors of odometry in units of 5 % of the way: a quarter of it, half of it. No wheels on a floor
/// do that.
constexpr UpperLimits kScanOdometryLimits{5, 10};
constexpr std::size_t kFewestScans = 10;

std::size_t count_of(const std::map<std::string, std::size_t>& dropped, const char* word) {
  std::size_t count = 0;
  for (const auto& [reason, times] : dropped) {
    if (reason.find(word) != std::string::npos) count += times;
  }
  return count;
}

HealthEntry share_entry(const char* name, std::size_t part, std::size_t all,
                        const UpperLimits& limits, const char* what, const char* knob) {
  return judged_entry(name, static_cast<double>(part) / static_cast<double>(all), limits,
                      fmt::format("{} of {} {}.", part, all, what), knob);
}

/// Scale of the odometry as matches of scans tell it. Where the map agrees with itself it is the
/// odometry that is off, and a path by scans does not follow it.
void check_wheels(const RunFacts& facts, Health& health) {
  const double length = facts.figure("odometry_times_translation");
  const double turn = facts.figure("odometry_times_rotation");
  HealthEntry entry = judged_entry(
      "scale of the odometry by scans", std::max(factor_off(length), factor_off(turn)),
      kWheelLimits,
      fmt::format("By matches of scans, the way that odometry tells is to be multiplied by {:.3g}, "
                  "and its turns by {:.3g}.",
                  length, turn),
      "units of the odometry; field of view of the laser ([sensor] fov_deg), units of its ranges");
  if (facts.run.agrees) entry.verdict = std::min(entry.verdict, HealthVerdict::kDoubtful);
  health.push_back(std::move(entry));
}

/// A robot that was moved while its odometry rested. Where the map agrees with itself, closures
/// have told where it was set down.
void check_carried(const RunFacts& facts, Health& health) {
  const double times = facts.figure("scans_carried");
  if (!(times > 0)) return;
  HealthEntry entry;
  entry.name = "robot that was carried";
  entry.value = times;
  entry.verdict = facts.run.agrees ? HealthVerdict::kGood : HealthVerdict::kDoubtful;
  entry.sentence = fmt::format(
      "{:.0f} times the odometry rests while what the laser sees changes at once: the robot was "
      "carried, or its odometry did not count. Closures alone tell where it was set down.",
      times);
  if (entry.verdict == HealthVerdict::kDoubtful) {
    entry.knob =
        "whether the robot was carried; map what comes before and after as logs of their own";
  }
  health.push_back(std::move(entry));
}

}  // namespace

void check_clouds(const RunFacts& facts, Health& health) {
  const auto clouds = static_cast<std::size_t>(facts.figure("clouds"));
  if (clouds < kFewestScans) return;
  health.push_back(share_entry(
      "clouds that see nothing", static_cast<std::size_t>(facts.figure("clouds_blind")), clouds,
      kSeeNothingLimits, "clouds show hardly a surface: there the path is by odometry alone",
      "which points of the log are valid, and the number of rings: one ring shows no surface"));
  health.push_back(share_entry(
      "clouds that agree with nothing", static_cast<std::size_t>(facts.figure("clouds_lost")),
      clouds, kAgreeWithNothingLimits, "clouds agree with no local map",
      "clouds that are missing or of another sensor; its pose on the "
      "robot; odometry, without which turns between clouds must be small"));
}

void check_scans(const RunFacts& facts, Health& health) {
  const auto count = [&](const char* name) { return static_cast<std::size_t>(facts.figure(name)); };
  const std::size_t scans = count("scans");
  if (scans < kFewestScans) return;
  health.push_back(share_entry("scans that see nothing", count("scans_blind"), scans,
                               kSeeNothingLimits,
                               "scans have fewer than ten returns: there the path is by odometry "
                               "alone",
                               "which rays of the log are valid, and its maximum range; [sensor] "
                               "max_range, [LaserScans] max_range"));
  health.push_back(share_entry("scans that agree with nothing", count("scans_lost"), scans,
                               kAgreeWithNothingLimits, "scans agree with no local map",
                               "scans that are missing or of another place; pose and field of view "
                               "of the sensor ([sensor] fov_deg); what moves around the robot"));
  check_carried(facts, health);
  const double odometry =
      std::max(facts.figure("odometry_translation_scale"), facts.figure("odometry_rotation_scale"));
  health.push_back(judged_entry(
      "odometry against scans", odometry, kScanOdometryLimits,
      fmt::format("Matches of scans and odometry differ by {:.2g} % of the way or turn.",
                  5 * odometry),
      "whether the odometry is that of this robot, in metres and radians, and not late; sign and "
      "pose of the sensor"));
  const bool is_measured =
      facts.figure("odometry_times_translation") > 0 && facts.figure("odometry_times_rotation") > 0;
  if (is_measured) check_wheels(facts, health);
}

void check_detections(const RunFacts& facts, Health& health) {
  const std::size_t moved = count_of(facts.run.dropped, "its thing moves");
  const std::size_t clutter = count_of(facts.run.dropped, "taken for clutter");
  const std::size_t all = std::max(facts.run.decided, facts.sightings.size() + moved + clutter);
  if (facts.run.associates() && all >= kFewestDetections) {
    health.push_back(share_entry("detections of moving things", moved, all, kMovedLimits,
                                 "detections were taken for those of things that move",
                                 "[sensor] sigma_range and sigma_yaw_deg: what scatters more than "
                                 "they say seems to move"));
    health.push_back(share_entry("detections without a landmark", clutter, all, kClutterLimits,
                                 "detections were taken for clutter",
                                 "noise of odometry and detections; the detector's threshold"));
  }
  const auto directions = static_cast<std::size_t>(facts.figure("directions"));
  if (directions >= kFewestDetections) {
    const auto used = static_cast<std::size_t>(facts.figure("directions_with_range"));
    health.push_back(share_entry(
        "directions without a range", directions - used, directions, kNoRangeLimits,
        "directions told no range of their thing, and are not used",
        "way of the robot: things get a place where it passes them, not where it drives straight "
        "at them; noise of the odometry, if it is better than stated: smaller ([reader] "
        "odometry_sigma_factor, or --walk-rotation and --walk-translation of hybrid-import); "
        "[BearingRangeAssociation] memory: longer, as 20; [sensor] sigma_yaw_deg: smaller, if it "
        "is"));
  }
  if (facts.ranges >= kFewestDetections) {
    health.push_back(share_entry("ranges taken for false", facts.false_ranges, facts.ranges,
                                 kClutterLimits, "ranges were taken for false",
                                 "[BeaconRanges] sigma"));
  }
}

}  // namespace hybrid
