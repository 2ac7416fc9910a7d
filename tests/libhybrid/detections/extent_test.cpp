// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/detections/sighting.h"

namespace hybrid {
namespace {

Detection detection() {
  Detection d;
  d.range = 3;
  d.yaw = 0.7;
  d.covariance.diagonal() << 0.01, 0.0004, 0;
  return d;
}

/// Of where it puts its landmark, in the frame of the sensor.
Eigen::Matrix3d position_covariance(const Detection& d, bool is_3d) {
  return point_sighting(Eigen::Isometry3d::Identity(), 0, d, is_3d).covariance;
}

TEST(Extent, IsTheSameInAllDirectionsOfThePlane) {
  const Eigen::Matrix3d own = position_covariance(detection(), false);
  const Eigen::Matrix3d with = position_covariance(with_extent(detection(), 0.4, false), false);
  const Eigen::Matrix3d planar = Eigen::Vector3d(0.16, 0.16, 0).asDiagonal();
  EXPECT_TRUE((with - own).isApprox(planar, 1e-9));
}

TEST(Extent, IsTheSameInAllDirectionsOfSpace) {
  Detection d = detection();
  d.pitch = -0.9;
  d.covariance(2, 2) = 0.0009;
  const Eigen::Matrix3d own = position_covariance(d, true);
  const Eigen::Matrix3d with = position_covariance(with_extent(d, 0.4, true), true);
  EXPECT_TRUE((with - own).isApprox(0.16 * Eigen::Matrix3d::Identity(), 1e-9));
}

TEST(Extent, OfALandmarkAroundTheSensorLeavesTheDirectionOpen) {
  Detection d = detection();
  d.range = 0.01;
  EXPECT_LE(with_extent(d, 1, false).covariance(1, 1), 1.01);
}

TEST(Extent, SigmaOfThePositionIsThatOfTheUsualAxis) {
  EXPECT_NEAR(position_sigma(detection(), false), std::sqrt(0.5 * (0.01 + 9 * 0.0004)), 1e-12);
  Detection d = detection();
  d.pitch = 0.5;
  d.covariance(2, 2) = 0.0009;
  EXPECT_NEAR(position_sigma(d, true), std::sqrt(position_covariance(d, true).trace() / 3), 1e-9);
}

}  // namespace
}  // namespace hybrid
