// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_sweep.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/support/cloud_worlds.h"

namespace hybrid {
namespace {

using testing::CloudWorld;
using testing::cluttered_hall;

SE3::Tangent fast() {
  SE3::Tangent velocity;
  velocity << 3, -1, 0.5, 0.1, -0.2, 1.5;
  return velocity;
}

/// How far a point is from the nearest surface of a world.
double distance_from(const CloudWorld& world, const Eigen::Vector3d& p) {
  const auto from = [&](const testing::Box3& box) {
    const Eigen::Vector3d outside = (box.low - p).cwiseMax(p - box.high);
    const Eigen::Vector3d clipped = outside.cwiseMax(0);
    return outside.maxCoeff() > 0 ? clipped.norm() : -outside.maxCoeff();
  };
  double nearest = from(world.hall);
  for (const testing::Box3& box : world.boxes) nearest = std::min(nearest, from(box));
  return nearest;
}

TEST(Deskewed, PointsOfASweepLieOnTheSurfacesThatItsRaysMet) {
  std::mt19937 random(1);
  for (const double begin : {0.0, -0.1}) {  // the stamp is that of the first ray, or in between
    const auto pose_at = [&](double time) { return SE3::exp((time + begin) * fast()); };
    testing::Sweep sweep = testing::sweep_at(cluttered_hall(), pose_at, 0.2, random, 1e-9);
    for (float& time : sweep.times) time += static_cast<float>(begin);
    const auto moved = deskewed(sweep.points, sweep.times, fast());
    ASSERT_EQ(moved.size(), sweep.points.size());
    double worst_before = 0;
    for (std::size_t i = 0; i < moved.size(); ++i) {
      EXPECT_LT(distance_from(cluttered_hall(), moved[i].cast<double>()), 1e-4) << i;
      worst_before =
          std::max(worst_before, distance_from(cluttered_hall(), sweep.points[i].cast<double>()));
    }
    EXPECT_GT(worst_before, 0.3);
  }
}

TEST(Deskewed, PointsWithoutATimeStay) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const std::vector<Eigen::Vector3f> points(6, Eigen::Vector3f(1, 2, 3));
  const auto moved = deskewed(points, {kNan, 0.5F, kInfinity, -1.5F, 1e9F, 0}, fast());
  for (std::size_t i = 0; i < points.size(); ++i) EXPECT_EQ(moved[i] == points[i], i != 1) << i;
  EXPECT_EQ(deskewed(points, {}, fast()), points);
  EXPECT_EQ(deskewed(points, {0.5F}, fast()), points);
  EXPECT_EQ(deskewed(points, std::vector<float>(6, 0.5F), SE3::Tangent::Zero()), points);
}

TEST(SweepVelocity, OdometryGoesBeforeMatches) {
  const SE3 odometry = SE3::exp(0.5 * fast()), matched = SE3::exp(0.25 * fast());
  SweepVelocity velocity;
  EXPECT_TRUE(velocity.at(7, odometry).isZero()) << "there is no cloud before";
  velocity.add(7, std::nullopt);
  EXPECT_TRUE(velocity.at(7.5, std::nullopt).isZero());
  EXPECT_LT((velocity.at(7.5, odometry) - fast()).norm(), 1e-12);
  velocity.add(7.5, matched);
  EXPECT_LT((velocity.at(7.75, std::nullopt) - 0.5 * fast()).norm(), 1e-12);
  EXPECT_LT((velocity.at(8, odometry) - fast()).norm(), 1e-12);
  velocity.add(8, std::nullopt);
  EXPECT_LT((velocity.at(8.5, std::nullopt) - 0.5 * fast()).norm(), 1e-12) << "the last match";
}

TEST(SweepVelocity, IsNotKnownOverALongTimeOrNone) {
  SweepVelocity velocity;
  velocity.add(0, std::nullopt);
  velocity.add(0.5, SE3::exp(fast()));
  EXPECT_FALSE(velocity.at(1, std::nullopt).isZero());
  for (const double time : {0.5, 0.4, 2.6, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_TRUE(velocity.at(time, SE3::exp(fast())).isZero()) << time;
  }
  EXPECT_TRUE(velocity.at(2.6, std::nullopt).isZero());
}

}  // namespace
}  // namespace hybrid
