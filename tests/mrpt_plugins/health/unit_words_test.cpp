// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/health/unit_words.h"

#include <gtest/gtest.h>

namespace hybrid {
namespace {

std::vector<std::string> words(double translation, double rotation, double sigma = 0.002) {
  CalibrationEstimate c;
  c.name = "odometry";
  c.entries = {{"scale of translation", "", translation, sigma, 1, std::nullopt, true},
               {"scale of rotation", "", rotation, sigma, 1, std::nullopt, true},
               {"drift", "deg/m", 3, sigma, 0, std::nullopt, true}};
  return unit_words({c});
}

TEST(UnitWords, TellWhatNoWheelExplains) {
  EXPECT_TRUE(words(1.04, 0.96).empty());
  EXPECT_TRUE(words(0.842, 1, 0.1).empty()) << "not sure";
  ASSERT_EQ(words(0.842, 1).size(), 1U);
  EXPECT_EQ(words(0.842, 1)[0],
            "ranges and odometry differ by 16 %: one of them has another unit or scale");
  for (const double feet : {3.28, 0.3048}) {
    EXPECT_EQ(words(feet, 1).at(0),
              "ranges and odometry differ by a factor of 3.28: one of them is in feet?");
  }
  EXPECT_EQ(words(1, 0.01746).at(0),
            "angles of detections and odometry differ by a factor of 57.3: one of them is in "
            "degrees?");
}

}  // namespace
}  // namespace hybrid
