// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/laser_mounting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/scan_worlds.h"

namespace hybrid {
namespace {

struct Truth {
  double stated = 1;  ///< field of view, to the true one
  bool clockwise = false;
  SE2 mounted;  ///< of the laser, which the log has at the robot's centre
  double odometry = 1.01;
};

LaserMounting measured(const Truth& truth, std::size_t most = 400) {
  const testing::FloorPlan plan = testing::ring();
  std::mt19937 random(3);
  std::normal_distribution<double> noise;
  std::vector<SE2> way = testing::way_around_ring(1, 0.15);
  way.resize(std::min(most, way.size()));
  std::vector<MovedScan> scans;
  for (std::size_t i = 0; i < way.size(); ++i) {
    MovedScan moved{plan.scan(way[i] * truth.mounted, 181, 0.01, random), {}};
    moved.scan.first_angle *= truth.stated;
    moved.scan.angle_step *= truth.stated;
    if (truth.clockwise) std::reverse(moved.scan.ranges.begin(), moved.scan.ranges.end());
    if (i > 0) {
      const SE2 step = way[i - 1].between(way[i]);
      moved.motion = SE2(truth.odometry * step.x() + 0.003 * noise(random),
                         truth.odometry * step.y(), step.angle() + 0.002 * noise(random));
    }
    scans.push_back(std::move(moved));
  }
  return measure_mounting(scans);
}

TEST(LaserMounting, IsAsStatedWhereItIs) {
  const LaserMounting found = measured({});
  EXPECT_TRUE(found.is_as_stated());
  EXPECT_EQ(found.unknown, "");
  EXPECT_LT(found.widening_sigma, 0.02);
  EXPECT_LT(found.sigmas.maxCoeff(), 0.02);
}

TEST(LaserMounting, TheFieldOfViewIsThatUnderWhichScansAgree) {
  // A field that is stated some per cent too narrow is not told from 110 scans.
  for (const double stated : {0.5, 1.5, 186.0 / 180, 190.0 / 180}) {
    Truth truth;
    truth.stated = stated;
    const LaserMounting found = measured(truth);
    EXPECT_NEAR(found.widening * stated, 1, 0.015) << stated << " +- " << found.widening_sigma;
    EXPECT_FALSE(found.mirrored);
    EXPECT_EQ(found.T_robot_stated.translation().norm(), 0) << stated;
  }
}

TEST(LaserMounting, RaysThatGoRoundTheOtherWay) {
  Truth truth;
  truth.clockwise = true;
  const LaserMounting found = measured(truth);
  EXPECT_TRUE(found.mirrored);
  EXPECT_EQ(found.widening, 1);
  EXPECT_EQ(found.T_robot_stated.translation().norm(), 0);
  EXPECT_EQ(found.T_robot_stated.angle(), 0);
}

TEST(LaserMounting, ALaserThatIsElsewhereOrTurned) {
  for (const SE2& mounted :
       {SE2(0.35, 0, 0), SE2(0, -0.2, 0), SE2(0, 0, 5 * M_PI / 180), SE2(0.3, 0.1, -M_PI / 2)}) {
    Truth truth;
    truth.mounted = mounted;
    const LaserMounting found = measured(truth);
    EXPECT_NEAR(found.T_robot_stated.x(), mounted.x(), 0.03) << found.sigmas.transpose();
    EXPECT_NEAR(found.T_robot_stated.y(), mounted.y(), 0.03) << found.sigmas.transpose();
    EXPECT_NEAR(found.T_robot_stated.angle(), mounted.angle(), 0.01) << found.sigmas.transpose();
  }
}

TEST(LaserMounting, ARobotThatDrivesStraightTellsTheFieldOfViewAlone) {
  Truth truth;
  truth.stated = 0.5;
  const LaserMounting found = measured(truth, 60);
  EXPECT_NEAR(found.widening, 2, 0.05);
  EXPECT_NE(found.unknown.find("hardly turns"), std::string::npos) << found.unknown;
  EXPECT_FALSE(found.mirrored);
  EXPECT_FALSE(measure_mounting({}).unknown.empty());
}

TEST(LaserMounting, CorrectsAScan) {
  LaserScan scan;
  scan.ranges.assign(5, 1.0F);
  scan.first_angle = -0.4;
  scan.angle_step = 0.2;
  LaserMounting mounting;
  mounting.widening = 2;
  mounting.mirrored = true;
  mounting.T_robot_stated = SE2(1, 2, M_PI_2);
  const LaserScan out = corrected(scan, mounting);
  EXPECT_NEAR(out.first_angle, 0.8, 1e-12);
  EXPECT_NEAR(out.angle_step, -0.4, 1e-12);
  EXPECT_TRUE(out.T_robot_sensor.translation().isApprox(Eigen::Vector3d(1, 2, 0)));
}

}  // namespace
}  // namespace hybrid
