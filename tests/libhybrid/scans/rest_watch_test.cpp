// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/rest_watch.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/support/scan_worlds.h"

namespace hybrid {
namespace {

class RestWatchTest : public ::testing::Test {
 protected:
  RestWatchTest() : plan_(testing::pillars(60, random_)) {}
  LaserScan scan(const SE2& at) { return plan_.scan(at, 181, 0.01, random_); }
  bool is_moved(const LaserScan& scan, const SE2& odometry = SE2()) {
    return watch_.is_moved(scan_points(scan), odometry);
  }

  std::mt19937 random_{7};
  testing::FloorPlan plan_;
  RestWatch watch_;
};

TEST_F(RestWatchTest, ARobotThatIsSetDownElsewhereIsMoved) {
  EXPECT_FALSE(is_moved(scan(SE2())));
  EXPECT_FALSE(is_moved(scan(SE2())));
  EXPECT_TRUE(is_moved(scan(SE2(0.8, -0.5, 2.0))));
  EXPECT_FALSE(is_moved(scan(SE2(0.8, -0.5, 2.0))));
  // Where odometry counts, or is missing, there is nothing to notice.
  EXPECT_FALSE(is_moved(scan(SE2()), SE2(0.5, 0, 0)));
  EXPECT_FALSE(watch_.is_moved(scan_points(scan(SE2(0.8, -0.5, 2.0))), std::nullopt));
}

TEST_F(RestWatchTest, OdometryMayBeLate) {
  is_moved(scan(SE2()));
  EXPECT_FALSE(is_moved(scan(SE2(0.1, 0, 0.05))));
}

TEST_F(RestWatchTest, WhoStepsBeforeTheLaserDoesNotMoveTheRobot) {
  is_moved(scan(SE2()));
  LaserScan hidden = scan(SE2());
  for (std::size_t k = 50; k < 120; ++k) hidden.ranges[k] = 0.5F;
  EXPECT_FALSE(is_moved(hidden));
  EXPECT_FALSE(is_moved(scan(SE2())));
}

TEST_F(RestWatchTest, LasersThatLookToBothSidesTakeTurns) {
  for (int i = 0; i < 4; ++i) {
    LaserScan rear = scan(SE2(0, 0, M_PI));
    rear.T_robot_sensor = Eigen::Isometry3d(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()));
    EXPECT_FALSE(is_moved(scan(SE2())));
    EXPECT_FALSE(is_moved(rear));
  }
}

}  // namespace
}  // namespace hybrid
