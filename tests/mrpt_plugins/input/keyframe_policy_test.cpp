// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/keyframe_policy.h"

#include <gtest/gtest.h>

namespace hybrid {
namespace {

LogStep step(double time, std::optional<mrpt::poses::CPose3D> motion) {
  LogStep s;
  s.time = time;
  if (motion) s.odometry = OdometryIncrement{*motion, Matrix6d::Identity(), false};
  return s;
}

const mrpt::poses::CPose3D kForward(1, 0, 0, 0, 0, 0), kTurn(0, 0, 0, 0.3, 0, 0);

/// Keyframes among 12 equal steps.
std::vector<int> keyframes(const KeyframeOptions& options, const mrpt::poses::CPose3D& motion) {
  KeyframePolicy policy(options);
  std::vector<int> found;
  for (int i = 0; i < 12; ++i) {
    if (policy.is_keyframe(step(0.5 * i, i == 0 ? std::nullopt : std::optional(motion)))) {
      found.push_back(i);
    }
  }
  return found;
}

TEST(KeyframePolicy, Thresholds) {
  EXPECT_EQ(keyframes({}, kForward).size(), 12U);
  EXPECT_EQ(keyframes({2.5, 0, 0}, kForward), (std::vector<int>{0, 3, 6, 9}));
  EXPECT_EQ(keyframes({2.5, 0, 0}, kTurn), (std::vector<int>{0}));
  EXPECT_EQ(keyframes({0, 1.0, 0}, kTurn), (std::vector<int>{0, 4, 8}));
  EXPECT_EQ(keyframes({0, 0, 2.0}, kTurn), (std::vector<int>{0, 4, 8}));
  EXPECT_EQ(keyframes({2.5, 0, 1.0}, kForward), (std::vector<int>{0, 2, 4, 6, 8, 10}));
}

TEST(KeyframePolicy, AddsUpMotionAndNoise) {
  KeyframePolicy policy({1.5, 0, 0});
  EXPECT_TRUE(policy.is_keyframe(step(0, std::nullopt)));
  EXPECT_FALSE(policy.odometry());
  EXPECT_FALSE(policy.is_keyframe(step(1, kForward)));
  EXPECT_TRUE(policy.is_keyframe(step(2, kForward)));
  ASSERT_TRUE(policy.odometry());
  EXPECT_NEAR(policy.odometry()->mean.x(), 2, 1e-12);
  // Two unit noises; the first one's rotation about z moves y by the second metre.
  EXPECT_NEAR(policy.odometry()->covariance(0, 0), 2, 1e-12);
  EXPECT_NEAR(policy.odometry()->covariance(1, 1), 3, 1e-12);
  EXPECT_NEAR(policy.odometry()->covariance(1, 5), 1, 1e-12);
  // The sum starts anew.
  EXPECT_FALSE(policy.is_keyframe(step(3, kForward)));
  EXPECT_TRUE(policy.is_keyframe(step(4, kForward)));
  EXPECT_NEAR(policy.odometry()->mean.x(), 2, 1e-12);
}

TEST(KeyframePolicy, AGapInOdometryMakesAKeyframe) {
  KeyframePolicy policy({10, 0, 0});
  EXPECT_TRUE(policy.is_keyframe(step(0, std::nullopt)));
  EXPECT_FALSE(policy.is_keyframe(step(1, kForward)));
  EXPECT_TRUE(policy.is_keyframe(step(2, std::nullopt)));
  EXPECT_FALSE(policy.odometry());
}

TEST(Odometry, ComposedCovarianceMatchesSampling) {
  const OdometryIncrement a{{1, 2, 0.5, 0.4, -0.3, 0.2}, 1e-4 * Matrix6d::Identity(), false};
  const OdometryIncrement b{{-1, 0.5, 2, -0.7, 0.1, 0.9}, 4e-4 * Matrix6d::Identity(), false};
  const auto composed = compose(a, b);
  // The same through MRPT's own first-order propagation in (x y z yaw pitch roll).
  auto mrpt = pose_pdf(a.mean, a.covariance);
  mrpt += pose_pdf(b.mean, b.covariance);
  EXPECT_TRUE(composed.covariance.isApprox(tangent_covariance(mrpt), 1e-6));
  EXPECT_NEAR(composed.mean.distanceTo(mrpt.mean), 0, 1e-12);
  EXPECT_FALSE(composed.is_planar);
}

}  // namespace
}  // namespace hybrid
