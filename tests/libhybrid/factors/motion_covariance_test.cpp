// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/factors/motion_covariance.h"

#include <gtest/gtest.h>

#include "libhybrid/factors/prior.h"
#include "libhybrid/geometry/se2.h"

namespace hybrid {
namespace {

/// The first pose of a robot in a map that there is already: it knows its place, and nothing of it
/// depends on the landmarks.
TEST(MotionCovariance, OfAFirstPoseAndOfTheLandmarksOfAMap) {
  const Key pose{'x', 0}, a{'l', 1}, b{'l', 2};
  Eigen::MatrixXd known(4, 4);
  known << 2, 0.5, 0.1, 0, 0.5, 3, 0, 0.2, 0.1, 0, 4, 0.3, 0, 0.2, 0.3, 5;
  Values newest;
  newest.insert(pose, SE2(1, 2, 0.3));
  Values values;
  values.insert(a, Eigen::Vector2d(0, 0));
  values.insert(b, Eigen::Vector2d(0, 0));
  const Eigen::Vector3d sigmas(0.1, 0.2, 0.05);
  const Prior<SE2> prior(pose, SE2(1, 2, 0.3), Noise::diagonal(sigmas));
  std::vector<Key> asked;
  const Eigen::MatrixXd joint = covariance_after_motion(
      prior, newest, values,
      [&](const std::vector<Key>& keys, const Eigen::MatrixXd& J) -> Eigen::MatrixXd {
        asked = keys;
        return J * known * J.transpose();
      },
      {a, b});
  EXPECT_EQ(asked, (std::vector<Key>{a, b}));
  ASSERT_EQ(joint.rows(), 7);
  ASSERT_EQ(joint.cols(), 7);
  EXPECT_TRUE(joint.topLeftCorner(3, 3).isApprox(
      Eigen::MatrixXd(sigmas.array().square().matrix().asDiagonal()), 1e-9));
  EXPECT_TRUE(joint.bottomRightCorner(4, 4).isApprox(known, 1e-12));
  EXPECT_TRUE(joint.topRightCorner(3, 4).isZero());
  EXPECT_TRUE(joint.bottomLeftCorner(4, 3).isZero());
}

}  // namespace
}  // namespace hybrid
