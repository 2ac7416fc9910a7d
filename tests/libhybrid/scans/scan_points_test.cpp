// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_points.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/support/scan_worlds.h"

namespace hybrid {
namespace {

using testing::FloorPlan;

FloorPlan wall_ahead() {
  FloorPlan plan;
  plan.add_wall({3, -10}, {3, 10});
  return plan;
}

TEST(ScanPoints, NormalsOfAWallPointToTheSensor) {
  std::mt19937 random(1);
  const auto points = scan_points(wall_ahead().scan(SE2(), 181, 0.01, random));
  int known = 0;
  for (const SurfacePoint& point : points) {
    EXPECT_NEAR(point.position.x(), 3.0, 0.05);
    if (!point.has_normal()) continue;
    ++known;
    EXPECT_LT(point.normal.x(), -0.97);
  }
  EXPECT_GT(known, static_cast<int>(points.size() / 2));
}

// Such as those of one of MRPT's simulated logs.
TEST(ScanPoints, RangesWithErrorsOfDecimetresAreSmoothed) {
  std::mt19937 random(1);
  FloorPlan room;
  room.add_box({-8, -5}, {9, 6});
  const auto points = scan_points(room.scan(SE2(), 361, 0.3, random));
  ASSERT_GT(points.size(), 20U);
  double squared = 0.0;
  std::size_t known = 0;
  for (const SurfacePoint& point : points) {
    const Eigen::Vector2d& p = point.position;
    const double off = std::min({std::abs(p.x() - 9), std::abs(p.y() - 6), std::abs(p.y() + 5)});
    squared += off * off;
    if (!point.has_normal()) continue;
    ++known;
    EXPECT_GT(point.normal.cwiseAbs().maxCoeff(), 0.7) << p.transpose();
  }
  EXPECT_LT(std::sqrt(squared / double(points.size())), 0.15);
  EXPECT_GT(known, points.size() / 2);
}

TEST(ScanPoints, AreSpacedEvenlyWhereRaysAreDense) {
  std::mt19937 random(1);
  const auto points = scan_points(wall_ahead().scan(SE2(), 1801, 0.0, random));
  ASSERT_GT(points.size(), 50u);
  for (std::size_t i = 1; i < points.size(); ++i) {
    EXPECT_GE((points[i].position - points[i - 1].position).norm(), 0.05);
  }
}

TEST(ScanPoints, RaysWithoutAReturnAreLeftOut) {
  LaserScan scan;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  scan.ranges = {nan, infinity, -1.0f, 0.0f, 80.0f, 2.0f};
  scan.angle_step = 0.1;
  const auto points = scan_points(scan);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_NEAR(points[0].position.norm(), 2.0, 1e-6);
  EXPECT_FALSE(points[0].has_normal());
  scan.ranges.clear();
  EXPECT_TRUE(scan_points(scan).empty());
}

TEST(ScanPoints, AScannerUpsideDownSeesLeftOnItsRight) {
  LaserScan scan;
  scan.ranges = {1.0f};
  scan.first_angle = 0.5 * M_PI;
  scan.T_robot_sensor =
      Eigen::Translation3d(0.2, 0, 0.3) * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
  const auto points = scan_points(scan);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_NEAR(points[0].position.x(), 0.2, 1e-9);
  EXPECT_NEAR(points[0].position.y(), -1.0, 1e-9);
}

TEST(ScanView, IsWhereItLooks) {
  std::mt19937 random(1);
  const ScanView view(scan_points(testing::ring().scan(SE2(-1, -1, 0), 181, 0.01, random)));
  EXPECT_TRUE(view.contains({0.5, 0.5}));
  EXPECT_FALSE(view.contains({-0.5, 0.1})) << "behind";
  EXPECT_FALSE(ScanView().contains({1, 0}));
}

}  // namespace
}  // namespace hybrid
