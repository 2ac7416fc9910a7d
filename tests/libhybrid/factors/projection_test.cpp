// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/factors/projection.h"

#include <gtest/gtest.h>

#include <limits>

#include "libhybrid/core/error.h"
#include "libhybrid/factors/expect_jacobians.h"
#include "libhybrid/factors/point_match.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

const Key kPose('c', 0), kPoint('p', 0), kCamera('k', 0);

TEST(Projection, JacobiansOfPosePointAndIntrinsics) {
  testing::Random random(1);
  for (int trial = 0; trial < 30; ++trial) {
    const SE3 pose = random.value<SE3>(0.7);
    Values values;
    values.insert(kPose, pose);
    values.insert(kPoint,
                  Eigen::Vector3d(pose * (Eigen::Vector3d(0, 0, 3) + random.vector<3>(0.6))));
    values.insert(kCamera, Intrinsics((Intrinsics() << 500, 320, 240, -0.1, 0.05).finished() +
                                      0.02 * random.vector<5>()));
    const Projection factor(kPose, kPoint, kCamera, {300, 200}, random.noise(2, 1.0));
    testing::expect_jacobians(factor, values, 1e-6);
  }
}

TEST(Projection, PixelOfAKnownPoint) {
  const Intrinsics camera = (Intrinsics() << 100, 50, 40, 0.1, 0.01).finished();
  // u = (0.5, 1), q = 1.25, s = 1 + 0.125 + 0.015625.
  const PinholeView view({1, 2, 2}, camera, false);
  EXPECT_NEAR(view.pixel.x(), 50 + 100 * 1.140625 * 0.5, 1e-9);
  EXPECT_NEAR(view.pixel.y(), 40 + 100 * 1.140625, 1e-9);
}

TEST(Projection, PointsBehindAreFiniteAndFarOff) {
  const Projection factor(kPose, kPoint, kCamera, {300, 200}, Noise::isotropic(2, 1.0));
  Values values;
  values.insert(kPose, SE3());
  values.insert(kCamera, Intrinsics((Intrinsics() << 500, 320, 240, 0, 0).finished()));
  values.insert(kPoint, Eigen::Vector3d(0.3, 0.2, -2.0));
  const auto l = testing::linearization(factor, values);
  EXPECT_TRUE(l.r.allFinite() && l.J.allFinite());
  EXPECT_GT(l.cost, 1e9);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Projection(kPose, kPoint, kCamera, {nan, 0}, Noise::unit(2)), Error);
}

TEST(PointMatch, Jacobian) {
  testing::Random random(2);
  for (int trial = 0; trial < 10; ++trial) {
    Values values;
    values.insert(kPose, random.value<SE3>(1.0));
    const PointMatch factor(kPose, random.vector<3>(), random.vector<3>(), random.noise(3));
    testing::expect_jacobians(factor, values);
  }
}

}  // namespace
}  // namespace hybrid
