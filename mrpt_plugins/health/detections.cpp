// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include "mrpt_plugins/health/detail/run_facts.h"

namespace hybrid {
namespace {

constexpr UpperLimits kMovedLimits{0.1, 0.5}, kClutterLimits{0.2, 0.5};
constexpr std::size_t kFewestDetections = 30;

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

}  // namespace

void check_detections(const RunFacts& facts, Health& health) {
  const std::size_t moved = count_of(facts.run.dropped, "its thing moves");
  const std::size_t clutter = count_of(facts.run.dropped, "taken for clutter");
  const std::size_t all = facts.sightings.size() + moved + clutter;
  if (facts.run.associates && all >= kFewestDetections) {
    health.push_back(share_entry("detections of moving things", moved, all, kMovedLimits,
                                 "detections were taken for those of things that move",
                                 "[sensor] sigma_range and sigma_yaw_deg: what scatters more than "
                                 "they say seems to move"));
    health.push_back(share_entry("detections without a landmark", clutter, all, kClutterLimits,
                                 "detections were taken for clutter",
                                 "noise of odometry and detections; the detector's threshold"));
  }
  if (facts.ranges >= kFewestDetections) {
    health.push_back(share_entry("ranges taken for false", facts.false_ranges, facts.ranges,
                                 kClutterLimits, "ranges were taken for false",
                                 "[BeaconRanges] sigma"));
  }
}

}  // namespace hybrid
