// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/detections/sensor_coverage.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/geometry/isometry.h"
#include "libhybrid/geometry/so2.h"
#include "libhybrid/landmarks/landmark_mapper.h"

namespace hybrid {
namespace {

DetectionFrame frame(double max_range, double fov_yaw, double fov_pitch = 0) {
  DetectionFrame out;
  out.is_3d = fov_pitch > 0;
  out.max_range = max_range;
  out.fov_yaw = fov_yaw;
  out.fov_pitch = fov_pitch;
  return out;
}

TEST(SensorCoverage, WhatAnObservationSaysOfItsSensorCounts) {
  SensorCoverage coverage;
  coverage.learn(frame(20, 1.5));
  EXPECT_EQ(coverage.max_range, 20);
  EXPECT_EQ(coverage.fov_yaw, 1.5);
  EXPECT_EQ(coverage.fov_pitch, 0);
}

TEST(SensorCoverage, ASensorThatSaysNothingReachesAsFarAsItHasSeen) {
  SensorCoverage coverage;
  DetectionFrame unknown = frame(0, 0);
  for (const double range : {3.0, 12.0, 7.0}) {
    Detection d;
    d.range = range;
    d.yaw = -0.05 * range;
    unknown.detections = {d};
    coverage.learn(unknown);
  }
  EXPECT_EQ(coverage.max_range, 12);
  EXPECT_DOUBLE_EQ(coverage.fov_yaw, 1.2);
}

TEST(SensorCoverage, ASensorThatLooksAsideSeesWhatIsThere) {
  SensorCoverage coverage;
  for (int i = 0; i < 100; ++i) {
    DetectionFrame unknown = frame(0, 0);
    Detection d;
    d.range = 10;
    d.yaw = wrap_angle(M_PI - 0.5 + 0.01 * (i * 37 % 101));  // behind it
    unknown.detections = {d};
    coverage.learn(unknown);
  }
  EXPECT_NEAR(coverage.fov_yaw, 1, 0.02);
  EXPECT_NEAR(std::abs(coverage.center_yaw), M_PI, 0.02);
  EXPECT_TRUE(coverage.well_in_view(Eigen::Isometry3d::Identity(), {-5, 1, 0}));
  EXPECT_TRUE(coverage.well_in_view(Eigen::Isometry3d::Identity(), {-5, -1, 0}));
  EXPECT_FALSE(coverage.well_in_view(Eigen::Isometry3d::Identity(), {5, 0, 0}));
  EXPECT_FALSE(coverage.well_in_view(Eigen::Isometry3d::Identity(), {0, 5, 0}));
}

TEST(SensorCoverage, AreaGrowsWithTheSquareOfTheRangeAndVolumeWithTheCube) {
  SensorCoverage plane, wide, space, deep;
  plane.learn(frame(10, 2));
  wide.learn(frame(20, 2));
  space.learn(frame(10, 2, 1));
  deep.learn(frame(20, 2, 1));
  EXPECT_DOUBLE_EQ(plane.space_in_view(), 100);  // 2 / 2 pi of pi 10^2
  EXPECT_DOUBLE_EQ(wide.space_in_view() / plane.space_in_view(), 4);
  EXPECT_DOUBLE_EQ(deep.space_in_view() / space.space_in_view(), 8);
  SensorCoverage sphere;
  sphere.learn(frame(3, 2 * M_PI, M_PI));
  EXPECT_NEAR(sphere.space_in_view(), 4.0 / 3 * M_PI * 27, 1e-9);
}

TEST(SensorCoverage, InViewIsWhatLiesBeforeTheSensorWithinItsRange) {
  SensorCoverage coverage;
  coverage.learn(frame(10, 1.0, 0.5));
  coverage.min_range = 1;
  // The sensor looks along the y axis of the map.
  const Eigen::Isometry3d T = to_isometry(SE2(100, 50, M_PI / 2));
  const auto sees = [&](double ahead, double left, double up) {
    return coverage.well_in_view(T, {100 - left, 50 + ahead, up});
  };
  EXPECT_TRUE(sees(5, 0, 0));
  EXPECT_TRUE(sees(5, 2, -1));
  EXPECT_FALSE(sees(-5, 0, 0));
  EXPECT_FALSE(sees(12, 0, 0));
  EXPECT_FALSE(sees(0.5, 0, 0));
  EXPECT_FALSE(sees(5, 4, 0));
  EXPECT_FALSE(sees(5, -4, 0));
  EXPECT_FALSE(sees(5, 0, 2));
}

TEST(SensorCoverage, WhatIsAssumedGivesWayToWhatIsCounted) {
  SensorCoverage coverage;
  EXPECT_EQ(coverage.expected_in_view(5), 5);
  EXPECT_EQ(coverage.detection_probability(0.5), 0.5);
  coverage.detections = 1e6;
  coverage.around = 3e6;
  coverage.in_view = 1e6;
  coverage.seen = 0.8e6;
  EXPECT_NEAR(coverage.expected_in_view(5), 3, 1e-3);
  EXPECT_NEAR(coverage.detection_probability(0.5), 0.8, 1e-3);
  coverage.seen = 0;  // never certain that a landmark would not be seen, nor that it would
  EXPECT_EQ(coverage.detection_probability(0.5), 0.1);
  coverage.seen = 1e6;
  EXPECT_EQ(coverage.detection_probability(0.5), 0.9);
}

/// A robot at rest sees a thing once, 5 m ahead, and then looks `looks` times in a direction [rad],
/// without seeing anything. Returns how many landmarks there are.
std::size_t landmarks_after_looking(double direction, int looks) {
  LandmarkMapper<SE2> mapper;
  const Noise still = Noise::isotropic(3, 1e-3);
  for (int i = 0; i <= looks; ++i) {
    DetectionFrame seen = frame(10, 1.0);
    if (i == 0) {
      Detection d;
      d.range = 5;
      d.covariance.diagonal() << 0.01, 1e-4, 0;
      seen.detections = {d};
    } else {
      seen.T_robot_sensor = to_isometry(SE2(0, 0, direction));
    }
    mapper.add(SE2(), still, {seen});
  }
  return mapper.landmarks().size();
}

TEST(SensorCoverage, ALandmarkIsMissedOnlyWhereTheSensorLooked) {
  EXPECT_EQ(landmarks_after_looking(0, 1), 1U);
  EXPECT_EQ(landmarks_after_looking(0, 29), 0U);
  EXPECT_EQ(landmarks_after_looking(M_PI, 29), 1U);
  EXPECT_EQ(landmarks_after_looking(1.0, 29), 1U);
}

TEST(SensorCoverage, TheDensityOfLandmarksIsThatWhereTheyAreDensest) {
  DetectionFrame frame;
  frame.is_3d = false;
  frame.fov_yaw = 2 * M_PI;
  std::map<std::string, SensorCoverage> sensors;
  EXPECT_EQ(density_of_landmarks(sensors, 5), 0);
  for (const auto& [label, range] : {std::pair("near", 2.0), std::pair("far", 20.0)}) {
    frame.max_range = range;
    sensors[label].learn(frame);
    EXPECT_NEAR(density_of_landmarks(sensors, 5), 5 / (M_PI * 4), 1e-12) << label;
  }
  sensors["blind"];  // which has not said how far it sees
  EXPECT_NEAR(density_of_landmarks(sensors, 5), 5 / (M_PI * 4), 1e-12);
}

}  // namespace
}  // namespace hybrid
