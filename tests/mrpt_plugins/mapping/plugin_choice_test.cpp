// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/plugin_choice.h"

#include <gtest/gtest.h>

namespace hybrid {
namespace {

using Uses = std::map<std::string, ObservationUse>;

/// Expects that a text has a part.
void expect_part(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << text;
}

TEST(WhyNothingMapped, IsToldByTheKindOfObservation) {
  const Uses fixes = {{"CObservationGPS", {300, {"Fixes"}}},
                      {"CObservationOdometry", {6000, {"odometry"}}}};
  const std::string frozen = why_nothing_mapped(
      fixes, {{"fix dropped: the receiver repeats the last one", 299}, {"row dropped: odd", 1}});
  EXPECT_EQ(frozen,
            "nothing was mapped: none of 300 fixes was used, and the path is dead reckoning; "
            "dropped: the receiver repeats the last one (299)");
  expect_part(why_nothing_mapped(fixes, {}), "two that agree with each other");
  expect_part(why_nothing_mapped({{"CObservationGPS", {1, {"Fixes"}}}}, {}),
              "the one fix of the log was not used");
  expect_part(
      why_nothing_mapped({{"CObservationPointCloud", {30, {"PointClouds"}}}},
                         {{"cloud dropped: no points", 30}}),
      "none of 30 clouds was used, and the path is dead reckoning; dropped: no points (30)");
  expect_part(why_nothing_mapped({{"CObservation2DRangeScan", {5, {"LaserScans"}}}}, {}),
              "none of 5 scans was used");
  const std::string detections = why_nothing_mapped(
      {{"CObservationBearingRange", {9, {"BearingRangeKnownIds"}}}, *fixes.begin()}, {});
  expect_part(detections, "are odometry and ranges in metres");
  expect_part(detections, "; nothing was mapped: none of 300 fixes");
}

TEST(WhyNothingMapped, WhatNoPluginUsesIsNamed) {
  expect_part(why_nothing_mapped({}, {}), "the log holds no observations of landmarks");
  expect_part(why_nothing_mapped({{"CObservationWirelessPower", {4, {}}}}, {}),
              "no plugin that was chosen uses what the log holds, 4 CObservationWirelessPower; -p");
}

}  // namespace
}  // namespace hybrid
