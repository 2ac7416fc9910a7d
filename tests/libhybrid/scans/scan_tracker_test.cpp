// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_tracker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/support/scan_worlds.h"

namespace hybrid {
namespace {

/// Where a tracker thinks that its keyframes are, in the frame of the first.
class Follower {
 public:
  TrackedScan track(const LaserScan& scan, const std::optional<SE2>& odometry) {
    const TrackedScan result = tracker.track(scan_points(scan), odometry);
    if (result.is_keyframe) {
      const KeyframeMotion& from = result.match ? *result.match : result.odometry;
      keyframes.push_back(keyframes.empty() ? SE2() : keyframes[from.from] * from.measured.motion);
    }
    pose = keyframes[result.keyframe] * result.T_keyframe_scan;
    return result;
  }

  ScanTracker tracker;
  std::vector<SE2> keyframes;
  SE2 pose;
};

std::vector<SE2> half_ring() {
  std::vector<SE2> way = testing::way_around_ring(1, 0.1);
  way.resize(way.size() / 2);
  return way;
}

double error_after(const std::vector<SE2>& way, Follower& follower, double scale,
                   bool with_odometry) {
  const testing::FloorPlan plan = testing::ring();
  std::mt19937 random(7);
  for (std::size_t i = 0; i < way.size(); ++i) {
    std::optional<SE2> odometry;
    if (with_odometry && i > 0) {
      const SE2 step = way[i - 1].between(way[i]);
      odometry = SE2(scale * step.x(), scale * step.y(), scale * step.angle());
    }
    follower.track(plan.scan(way[i], 181, 0.01, random), odometry);
  }
  return (way.front().between(way.back()).translation() - follower.pose.translation()).norm();
}

TEST(ScanTracker, FollowsWithGoodOdometry) {
  Follower follower;
  EXPECT_LT(error_after(half_ring(), follower, 1.0, true), 0.15);
  EXPECT_EQ(follower.tracker.lost(), 0u);
  EXPECT_LT(follower.tracker.odometry_noise().translation_scale(), 1.5);
}

TEST(ScanTracker, FollowsWithoutOdometry) {
  Follower follower;
  EXPECT_LT(error_after(half_ring(), follower, 1.0, false), 0.3);
}

// A corridor looks alike everywhere: a robot that has gone on does not stand.
TEST(ScanTracker, WhereScansAreMissingOdometryLeads) {
  for (const std::size_t missing : {30, 60, 120}) {
    SCOPED_TRACE(missing);
    std::vector<SE2> way = half_ring();
    const auto gap = way.begin() + 100;
    way.erase(gap, gap + static_cast<std::ptrdiff_t>(missing));
    Follower follower;
    EXPECT_LT(error_after(way, follower, 1.0, true), 0.3);
  }
}

TEST(ScanTracker, MeasuresThatOdometryIsBad) {
  for (const double scale : {0.6, 0.8, 1.2, 1.35}) {
    SCOPED_TRACE(scale);
    Follower follower;
    EXPECT_LT(error_after(half_ring(), follower, scale, true), 0.1);
    EXPECT_NEAR(follower.tracker.odometry_noise().calibration()[0], 1.0 / scale, 0.25);
  }
}

TEST(ScanTracker, TakesScaleAndDriftOutOfOdometry) {
  const testing::FloorPlan plan = testing::ring();
  std::mt19937 random(7);
  Follower follower;
  const std::vector<SE2> way = testing::way_around_ring(1, 0.1);
  for (std::size_t i = 0; i < way.size(); ++i) {
    std::optional<SE2> odometry;
    if (i > 0) {
      const SE2 step = way[i - 1].between(way[i]);
      odometry = SE2(step.x() / 1.02, step.y() / 1.02,
                     (step.angle() - 0.004 * step.translation().norm()) / 0.98);
    }
    follower.track(plan.scan(way[i], 181, 0.01, random), odometry);
  }
  const OdometryCalibration2 found = follower.tracker.odometry_noise().calibration();
  EXPECT_NEAR(found[0], 1.02, 0.005);
  EXPECT_NEAR(found[1], 0.98, 0.006);
  EXPECT_NEAR(found[2], 0.004, 0.002);
  EXPECT_LT(follower.tracker.odometry_noise().translation_scale(), 0.5);
}

TEST(ScanTracker, StandingStillMakesNoKeyframes) {
  const testing::FloorPlan plan = testing::ring();
  std::mt19937 random(7);
  Follower follower;
  std::vector<LaserScan> scans;
  for (int i = 0; i < 20; ++i) scans.push_back(plan.scan(SE2(-1, -1, 0.2), 181, 0.01, random));
  for (int i = 0; i < 3000; ++i) follower.track(scans[i % scans.size()], SE2());
  EXPECT_LE(follower.keyframes.size(), 2u);
  EXPECT_LT(follower.pose.translation().norm(), 0.02);
}

TEST(ScanTracker, BlindScansFollowOdometry) {
  LaserScan blind;
  blind.ranges.assign(181, std::numeric_limits<float>::quiet_NaN());
  blind.angle_step = M_PI / 180.0;
  Follower follower;
  for (int i = 0; i <= 100; ++i) {
    const TrackedScan scan = follower.track(blind, SE2(0.1, 0, 0));
    EXPECT_FALSE(scan.match.has_value());
  }
  EXPECT_NEAR(follower.pose.x(), 10.0, 1e-6);
  EXPECT_EQ(follower.tracker.lost(), 0u);
  blind.ranges = {2.0f};
  for (int i = 0; i < 100; ++i) follower.track(blind, std::nullopt);
  EXPECT_TRUE(std::isfinite(follower.pose.x()));
}

TEST(ScanTracker, ALaserThatLooksWhereNoneHasLookedIsPlacedByMotion) {
  const testing::FloorPlan plan = testing::ring();
  std::mt19937 random(7);
  const std::vector<SE2> way = half_ring();
  Follower follower;
  double worst = 0;
  for (std::size_t i = 0; i < way.size(); ++i) {
    LaserScan scan = plan.scan(way[i] * SE2(0, 0, i % 2 == 0 ? 0 : M_PI), 61, 0.01, random);
    if (i % 2 == 1) scan.T_robot_sensor = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ());
    std::optional<SE2> odometry;
    if (i > 0) odometry = way[i - 1].between(way[i]);
    follower.track(scan, odometry);
    const SE2 truth = way.front().between(way[i]);
    worst = std::max(worst, (follower.pose.translation() - truth.translation()).norm());
  }
  EXPECT_LT(worst, 0.1);
  EXPECT_EQ(follower.tracker.lost(), 0u);
}

TEST(ScanTracker, WhereScansAreLostOdometryLeads) {
  const testing::FloorPlan plan = testing::ring();
  std::mt19937 random(7);
  std::uniform_real_distribution<float> anywhere(1, 20);
  Follower follower;
  SE2 way;
  for (int i = 0; i < 40; ++i) {
    // While it turns, odometry is late, and then all scans are of dust.
    const SE2 step = i < 20 ? SE2(0.1, 0, 0.05) : SE2(0.1, 0, 0);
    if (i > 0) way = way * step;
    LaserScan scan = plan.scan(SE2(-1, -1, -0.5) * way, 181, 0.01, random);
    if (i >= 20)
      std::generate(scan.ranges.begin(), scan.ranges.end(), [&] { return anywhere(random); });
    follower.track(scan, i < 20 ? SE2(i % 2 == 0 ? 0.2 : 0, 0, i % 2 == 0 ? 0.1 : 0) : step);
  }
  EXPECT_GT(follower.tracker.lost(), 5u);
  EXPECT_NEAR(follower.pose.angle(), way.angle(), 0.15);
}

TEST(ScanTracker, AJumpToAnotherPlaceBeginsALocalMap) {
  const testing::FloorPlan plan = testing::ring();
  std::mt19937 random(7);
  Follower follower;
  for (int i = 0; i < 20; ++i) {
    follower.track(plan.scan(SE2(-1 + 0.1 * i, -1, 0.0), 361, 0.01, random), SE2(0.1, 0, 0));
  }
  const testing::FloorPlan other = testing::pillars(60, random);
  TrackedScan jumped;
  for (int i = 0; i < 20; ++i) {
    const TrackedScan scan = follower.track(other.scan(SE2(0.05 * i, 0, 0.5), 361, 0.01, random),
                                            SE2(0.05 * std::cos(0.5), -0.05 * std::sin(0.5), 0));
    if (i == 0) jumped = scan;
  }
  EXPECT_TRUE(jumped.is_keyframe);
  EXPECT_FALSE(jumped.match.has_value());
  EXPECT_GT(jumped.odometry.measured.covariance(0, 0), 0.05);
  EXPECT_EQ(follower.tracker.local_maps().back().anchor, jumped.keyframe);
  EXPECT_EQ(follower.tracker.lost(), 1u);
  EXPECT_EQ(follower.tracker.carried(), 0u);
}

TEST(ScanTracker, ARobotThatIsCarriedIsInNoLocalMap) {
  const testing::FloorPlan plan = testing::ring();
  const std::vector<SE2> way = half_ring();
  std::mt19937 random(7);
  Follower follower;
  const auto see = [&](const SE2& at, const SE2& odometry) {
    return follower.track(plan.scan(at, 181, 0.01, random), odometry);
  };
  for (int i = 1; i < 120; ++i) see(way[i], way[i - 1].between(way[i]));
  for (int i = 0; i < 5; ++i) see(way[119], SE2());  // it rests
  EXPECT_EQ(follower.tracker.carried(), 0u);
  const SE2 step(0.1, 0, 0);
  SE2 at = way[60] * SE2(0, 0, 0.6);
  const TrackedScan set_down = see(at, SE2());
  EXPECT_EQ(follower.tracker.carried(), 1u);
  EXPECT_TRUE(set_down.is_keyframe);
  EXPECT_FALSE(set_down.match.has_value());
  EXPECT_GT(set_down.odometry.measured.covariance(0, 0), 20);  // odometry, which is zero, is wrong
  for (int i = 0; i < 5; ++i) see(at = at * step, step);
  EXPECT_EQ(follower.tracker.lost(), 1u);
}

}  // namespace
}  // namespace hybrid
