// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/sweep_calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "libhybrid/clouds/cloud_tracker.h"
#include "tests/support/cloud_worlds.h"

namespace hybrid {
namespace {

using testing::cluttered_hall;

constexpr double kBetween = 0.5;  // s, from cloud to cloud

/// At 1.5 m/s around the hall, turning faster and slower.
SE3 place_at(double time) {
  return testing::place_around_hall((1.5 * time + 0.4 * std::sin(time)) / 5);
}

/// What is seen while a lidar turns once, to the left, in `duration` [s]; it looks ahead at `time`.
std::vector<Eigen::Vector3f> seen_at(double time, double duration, std::mt19937& random) {
  // sweep_at() begins ahead, so that the halves of two sweeps make one that begins behind.
  const auto pose_at = [&](double later) { return place_at(time + later); };
  std::vector<Eigen::Vector3f> out;
  const testing::Sweep after = testing::sweep_at(cluttered_hall(), pose_at, duration, random);
  const testing::Sweep before = testing::sweep_at(
      cluttered_hall(), [&](double later) { return pose_at(later - duration); }, duration, random);
  for (std::size_t i = 0; i < after.points.size(); ++i) {
    out.push_back(after.points[i].y() > 0 ? after.points[i] : before.points[i]);
  }
  return out;
}

struct Followed {
  double share = 0, sigma = 0, error = 0;
};

/// Follows a lidar by odometry with noise; `keep` tells which points it has.
template <class Keep>
Followed run(double duration, bool is_at_once, const Keep& keep) {
  CloudTracker tracker;
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0, 0.02);
  UncertainMotion3 odometry{SE3(), 4e-4 * Matrix6::Identity()};
  SE3 pose;
  Followed out;
  for (int i = 0; i < 50; ++i) {
    const double time = kBetween * i;
    std::vector<Eigen::Vector3f> points = seen_at(time, duration, random);
    points.erase(std::remove_if(points.begin(), points.end(),
                                [&](const Eigen::Vector3f& p) { return !keep(p); }),
                 points.end());
    if (i > 0) {
      SE3::Tangent error;
      for (int k = 0; k < 6; ++k) error[k] = (k < 3 ? 1 : 0.2) * noise(random);
      odometry.motion = place_at(time - kBetween).between(place_at(time)) * SE3::exp(error);
      pose = pose * tracker.track(points, {0, 0, 0}, odometry, is_at_once).T_before_cloud;
    } else {
      tracker.track(points, {0, 0, 0}, std::nullopt, is_at_once);
    }
    const SE3 off = place_at(0).between(place_at(time)).between(pose);
    out.error += off.translation().squaredNorm() / 50;
  }
  out.error = std::sqrt(out.error);
  out.share = tracker.sweep().share();
  out.sigma = tracker.sweep().sigma();
  std::printf("%.1f s: share %.4f +- %.4f, error %.4f m\n", duration, out.share, out.sigma,
              out.error);
  return out;
}

const auto kEveryPoint = [](const Eigen::Vector3f&) { return true; };
const auto kAhead = [](const Eigen::Vector3f& p) { return p.x() > std::abs(p.y()); };

TEST(SweepCalibration, FindsHowLongALidarTakesToTurn) {
  const Followed found = run(0.1, false, kEveryPoint);
  EXPECT_NEAR(found.share, 0.2, 0.02);
  EXPECT_LT(found.error, 0.5 * run(0.1, true, kEveryPoint).error);
}

TEST(SweepCalibration, FindsMostOfATurnThatTakesMoreThanHalfTheTime) {
  const Followed found = run(0.3, false, kEveryPoint);
  EXPECT_GT(found.share, 0.4);  // of 0.6: .43 and .55 in two halls, within .02 whatever is drawn
  EXPECT_LT(found.share, 0.65);
  EXPECT_LT(found.error, 0.7 * run(0.3, true, kEveryPoint).error);
}

TEST(SweepCalibration, FindsNoneWhereAllIsSeenAtOnce) {
  const Followed found = run(0, false, kEveryPoint);
  EXPECT_NEAR(found.share, 0, 0.02);
  EXPECT_LT(found.sigma, 0.02);
  EXPECT_LT(found.error, 1.5 * run(0, true, kEveryPoint).error + 0.005);
}

TEST(SweepCalibration, LeavesACameraAsItIs) {
  EXPECT_EQ(run(0.3, false, kAhead).share, 0);
}

}  // namespace
}  // namespace hybrid
