// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/geometry/polar.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "tests/support/random.h"

namespace hybrid {
namespace {

template <int N>
void check_inverse() {
  testing::Random random{31};
  for (int trial = 0; trial < 20; ++trial) {
    const Eigen::Matrix<double, N, 1> p = random.vector<N>(3.0);
    Eigen::Matrix<double, N, N> to, from;
    const auto z = to_polar(p, &to);
    EXPECT_NEAR(z[0], p.norm(), 1e-14);
    EXPECT_LT((from_polar(z, &from) - p).norm(), 1e-13);
    EXPECT_LT((to * from - Eigen::Matrix<double, N, N>::Identity()).norm(), 1e-12);
    for (int d = 0; d < N; ++d) {
      const Eigen::Matrix<double, N, 1> step = 1e-6 * Eigen::Matrix<double, N, 1>::Unit(d);
      const Eigen::Matrix<double, N, 1> forth = z + step;
      const Eigen::Matrix<double, N, 1> back = z - step;
      EXPECT_LT((from.col(d) - (from_polar(forth) - from_polar(back)) / 2e-6).norm(), 1e-7);
    }
  }
}

TEST(Polar, InverseAndJacobians) {
  check_inverse<2>();
  check_inverse<3>();
}

TEST(Polar, AtTheOriginAllIsZero) {
  EXPECT_EQ(to_polar(Eigen::Vector2d(0.0, 0.0)).norm(), 0.0);
  EXPECT_EQ(to_polar(Eigen::Vector3d(0.0, 0.0, 0.0)).norm(), 0.0);
}

// There, and closer than the limit of derivatives of angles, they point as just outside.
TEST(Polar, DerivativesNearTheOriginAreThoseOfTheirDirection) {
  Eigen::Matrix2d J, limit;
  to_polar(Eigen::Vector2d(kMinDistance, 0.0), &limit);
  for (double x : {0.0, 1e-300, 1e-12, 1e-7}) {
    to_polar(Eigen::Vector2d(x, 0.0), &J);
    EXPECT_LT((J - limit).norm(), 1e-9 * limit.norm()) << x;
  }
  Eigen::Matrix3d J3, limit3;
  to_polar(Eigen::Vector3d(kMinDistance, 0.0, 0.0), &limit3);
  for (double x : {0.0, 1e-300, 1e-12, 1e-7}) {
    to_polar(Eigen::Vector3d(x, 0.0, 0.0), &J3);
    EXPECT_LT((J3 - limit3).norm(), 1e-9 * limit3.norm()) << x;
  }
  to_polar(Eigen::Vector2d(0.0, -1e-9), &J);
  EXPECT_LT((J.row(0) - Eigen::RowVector2d(0.0, -1.0)).norm(), 1e-12);
}

TEST(Polar, OnTheAxisPitchIsRightAndDerivativesAreBounded) {
  Eigen::Matrix3d J;
  const Eigen::Vector3d z = to_polar(Eigen::Vector3d(0.0, 0.0, 2.0), &J);
  EXPECT_NEAR(z[0], 2.0, 1e-15);
  EXPECT_EQ(z[1], 0.0);
  EXPECT_NEAR(z[2], -M_PI / 2, 1e-15);
  EXPECT_LE(J.cwiseAbs().maxCoeff(), 1.0 / kMinDistance);
}

}  // namespace
}  // namespace hybrid
