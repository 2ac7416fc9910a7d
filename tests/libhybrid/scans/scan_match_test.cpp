// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_match.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/scan_worlds.h"

namespace hybrid {
namespace {

using testing::FloorPlan;

constexpr double kRangeNoise = 0.015;

std::vector<SurfacePoint> points_seen(const FloorPlan& plan, const SE2& pose,
                                      std::mt19937& random) {
  return scan_points(plan.scan(pose, 361, kRangeNoise, random));
}

FloorPlan corridor() {
  FloorPlan plan;
  plan.add_wall({-50, 1}, {50, 1});
  plan.add_wall({-50, -1}, {50, -1});
  return plan;
}

TEST(Align, ErrorsAreThoseThatItsCovarianceTells) {
  std::vector<double> nees;
  double worst = 0.0;
  for (int seed = 0; seed < 50; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> offset(-0.2, 0.2);
    const FloorPlan plan = testing::furnished_room();
    const SurfaceMap map(points_seen(plan, SE2(), random));
    const SE2 truth(offset(random), offset(random), offset(random));
    const ScanAlignment found = align(points_seen(plan, truth, random), map, SE2());
    const Eigen::Vector3d error = truth.between(found.pose).log();
    worst = std::max(worst, error.head<2>().norm());
    EXPECT_GT(found.inliers, 0.7);
    nees.push_back(error.dot(alignment_covariance(found).llt().solve(error)) / 3.0);
  }
  std::nth_element(nees.begin(), nees.begin() + 25, nees.end());
  EXPECT_LT(nees[25], 1.5);
  EXPECT_GT(nees[25], 0.01);
  EXPECT_LT(worst, 0.03);
}

TEST(Align, ACorridorTellsNothingAlongItself) {
  for (int seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    const SurfaceMap map(points_seen(corridor(), SE2(), random));
    AlignmentOptions options;
    options.prior = Eigen::Vector3d(1e2, 1e2, 1e2).asDiagonal();
    const ScanAlignment found =
        align(points_seen(corridor(), SE2(0.3, 0.05, 0.02), random), map, SE2(), options);
    const Eigen::Matrix2d R = found.pose.rotation().matrix();
    const Eigen::Matrix2d covariance =
        R * alignment_covariance(found).topLeftCorner<2, 2>() * R.transpose();
    EXPECT_GT(std::sqrt(covariance(0, 0)), 0.1) << seed;
    EXPECT_LT(std::sqrt(covariance(1, 1)), 0.03) << seed;
    EXPECT_NEAR(found.pose.y(), 0.05, 0.02) << seed;
    EXPECT_NEAR(found.pose.angle(), 0.02, 0.01) << seed;
  }
}

// Errors of the directions of walls seem to tell the place along them, a little at each scan: a
// speed that goes on by itself was off by some 20 cm after ten of them.
TEST(Align, ASteadyMotionGoesOnAlongACorridor) {
  const SE2 step(0.1, 0.0, 0.0);
  AlignmentOptions options;
  options.prior = Eigen::Vector3d(0.04, 0.04, 0.05).cwiseAbs2().cwiseInverse().asDiagonal();
  for (int seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    const SurfaceMap map(points_seen(corridor(), SE2(), random));
    SE2 at, motion = step;
    for (int i = 1; i <= 10; ++i) {
      const auto points = points_seen(corridor(), SE2(i * step.x(), 0.0, 0.0), random);
      const SE2 next = align(points, map, at * motion, options).pose;
      motion = at.between(next);
      at = next;
    }
    EXPECT_NEAR(at.x(), 10 * step.x(), 0.02) << seed;
  }
}

TEST(Align, NothingToAlignKeepsTheStart) {
  const ScanAlignment found = align({}, SurfaceMap(), SE2(1, 2, 0.5));
  EXPECT_EQ(found.pose.x(), 1.0);
  EXPECT_EQ(found.inliers, 0.0);
  EXPECT_TRUE(alignment_covariance(found).allFinite());
  EXPECT_GT(alignment_covariance(found)(0, 0), 100.0);
}

TEST(Match, FindsThePoseInAWindow) {
  double worst = 0.0;
  for (int seed = 0; seed < 20; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> offset(-0.9, 0.9);
    const FloorPlan plan = testing::furnished_room();
    const MatchTarget target = make_match_target(points_seen(plan, SE2(), random));
    const SE2 truth(offset(random), offset(random), 0.5 * offset(random));
    const auto modes = match(points_seen(plan, truth, random), target, {SE2(), {1.0, 1.0}, 0.6});
    ASSERT_FALSE(modes.empty()) << seed;
    const SE2 error = truth.between(modes[0].pose.motion);
    worst = std::max(worst, error.translation().norm());
    EXPECT_NEAR(error.angle(), 0.0, 0.02) << seed;
  }
  EXPECT_LT(worst, 0.05);
}

TEST(Match, OfAnotherPlaceHasNoMode) {
  std::mt19937 random(1);
  const MatchTarget target =
      make_match_target(points_seen(testing::furnished_room(), SE2(), random));
  FloorPlan other;
  for (int i = 0; i < 12; ++i) {
    other.add_wall({0.5 + 0.4 * i, -2.0 + 0.3 * i}, {0.7 + 0.4 * i, -2.2 + 0.3 * i});
  }
  MatchOptions options;
  options.min_inliers = 0.6;
  EXPECT_TRUE(
      match(points_seen(other, SE2(), random), target, {SE2(), {1.0, 1.0}, 0.6}, options).empty());
}

}  // namespace
}  // namespace hybrid
