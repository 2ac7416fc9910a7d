// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/factors/motion_covariance.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "libhybrid/factors/calibrated_motion.h"
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
  const MotionCovariance after(
      prior, pose, newest, values,
      [&](const std::vector<Key>& keys, const Eigen::MatrixXd& J) -> Eigen::MatrixXd {
        asked = keys;
        return J * known * J.transpose();
      });
  const Eigen::MatrixXd joint = after({a, b});
  EXPECT_EQ(asked, (std::vector<Key>{a, b}));
  ASSERT_EQ(joint.rows(), 7);
  ASSERT_EQ(joint.cols(), 7);
  EXPECT_TRUE(joint.topLeftCorner(3, 3).isApprox(
      Eigen::MatrixXd(sigmas.array().square().matrix().asDiagonal()), 1e-9));
  EXPECT_TRUE(joint.bottomRightCorner(4, 4).isApprox(known, 1e-12));
  EXPECT_TRUE(joint.topRightCorner(3, 4).isZero());
  EXPECT_TRUE(joint.bottomLeftCorner(4, 3).isZero());
}

/// The same as in the graph that has the motion already, by the inverse of its information: with
/// the calibration, which ties the new pose to more than the one before.
TEST(MotionCovariance, OfACalibratedMotionIsThatOfTheGraphThatHasIt) {
  const Key from{'x', 0}, to{'x', 1}, calibration{'c', 0}, landmark{'l', 1};
  Eigen::MatrixXd root(8, 8);  // of from, calibration, landmark
  for (int i = 0; i < 8; ++i) {
    for (int j = 0; j < 8; ++j) root(i, j) = i == j ? 1.0 + 0.1 * i : 0.1 * ((3 * i + 5 * j) % 4);
  }
  const Eigen::MatrixXd known = root * root.transpose();
  Values values;
  values.insert(from, SE2(1, 2, 0.3));
  values.insert(calibration, OdometryCalibration2(0.02, -0.01, 0.05));
  values.insert(landmark, Eigen::Vector2d(4, 1));
  Values newest;
  newest.insert(to, SE2(2.1, 2.6, 0.7));
  const CalibratedMotion2 motion(from, to, calibration, SE2(1.2, 0.1, 0.4),
                                 Noise::diagonal(Eigen::Vector3d(0.1, 0.2, 0.05)));
  const std::vector<Key> order{from, calibration, landmark};
  const std::vector<Eigen::Index> begin{0, 3, 6}, dims{3, 3, 2};
  const MotionCovariance after(
      motion, to, newest, values,
      [&](const std::vector<Key>& keys, const Eigen::MatrixXd& J) -> Eigen::MatrixXd {
        Eigen::MatrixXd all = Eigen::MatrixXd::Zero(J.rows(), 8);
        Eigen::Index at = 0;
        for (const Key key : keys) {
          const std::size_t k = std::find(order.begin(), order.end(), key) - order.begin();
          all.middleCols(begin[k], dims[k]) += J.middleCols(at, dims[k]);
          at += dims[k];
        }
        return all * known * all.transpose();
      });

  const double* x[] = {values.data(from), newest.data(to), values.data(calibration)};
  Eigen::Vector3d r;
  Eigen::Matrix<double, 3, 9> linear;  // of from, to, calibration
  motion.linearize(x, r.data(), linear.data());
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(3, 11);  // of from, calibration, landmark, to
  rows << linear.leftCols(3), linear.rightCols(3), Eigen::MatrixXd::Zero(3, 2),
      linear.middleCols(3, 3);
  Eigen::MatrixXd information = rows.transpose() * rows;
  information.topLeftCorner(8, 8) += known.inverse();
  const Eigen::MatrixXd all = information.inverse();
  Eigen::MatrixXd expected(5, 5);  // of to, landmark
  expected << all.bottomRightCorner(3, 3), all.block(8, 6, 3, 2), all.block(6, 8, 2, 3),
      all.block(6, 6, 2, 2);
  EXPECT_TRUE(after({landmark}).isApprox(expected, 1e-9));
}

}  // namespace
}  // namespace hybrid
