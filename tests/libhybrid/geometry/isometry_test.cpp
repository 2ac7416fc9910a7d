// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/geometry/isometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "libhybrid/geometry/polar.h"

namespace hybrid {
namespace {

using Eigen::Isometry3d;

class Isometries : public ::testing::Test {
 protected:
  double uniform() { return std::uniform_real_distribution<double>(-1, 1)(random_); }
  SE3 spatial() {
    SE3::Tangent v;
    for (int i = 0; i < 6; ++i) v[i] = (i < 3 ? 10 : 1.5) * uniform();
    return SE3::exp(v);
  }
  SE2 planar() { return {10 * uniform(), 10 * uniform(), M_PI * uniform()}; }

 private:
  std::mt19937 random_{6};
};

TEST_F(Isometries, AreTheGroupsOfPlaneAndSpace) {
  for (int i = 0; i < 100; ++i) {
    const SE3 a = spatial(), b = spatial();
    const Isometry3d A = to_isometry(a), B = to_isometry(b);
    EXPECT_TRUE(A.matrix().isApprox(a.matrix(), 1e-12));
    EXPECT_TRUE(compose(A, B).matrix().isApprox((a * b).matrix(), 1e-12));
    EXPECT_TRUE(between(A, B).matrix().isApprox(a.between(b).matrix(), 1e-12));
    EXPECT_TRUE(adjoint(A).isApprox(a.adjoint(), 1e-12));
    EXPECT_LT(to_se3(A).between(a).log().norm(), 1e-12);
    const SE2 p = planar(), q = planar();
    const SE2 pq = to_se2(compose(to_isometry(p), to_isometry(q)));
    EXPECT_LT((p * q).between(pq).log().norm(), 1e-12);
    EXPECT_LT(p.between(to_se2(to_isometry(p))).log().norm(), 1e-12);
  }
}

TEST_F(Isometries, ADirectionIsThatOfPolarCoordinates) {
  for (int i = 0; i < 100; ++i) {
    const double yaw = M_PI * uniform(), pitch = 0.5 * M_PI * uniform();
    const Eigen::Vector3d d = direction(yaw, pitch);
    EXPECT_TRUE(d.isApprox(from_polar(Eigen::Vector3d(1, yaw, pitch)), 1e-12));
    const SE3 T = spatial();
    EXPECT_TRUE(rotated(to_isometry(T), d).isApprox(T.rotation() * d, 1e-12));
  }
}

TEST_F(Isometries, PitchAndRollAreTiltsYawIsNone) {
  EXPECT_FALSE(is_tilted(Isometry3d::Identity()));
  for (int i = 0; i < 20; ++i) EXPECT_FALSE(is_tilted(to_isometry(planar())));
  for (int axis = 0; axis < 2; ++axis) {
    for (const double angle : {1e-6, 0.3, M_PI}) {
      SE3::Tangent v = SE3::Tangent::Zero();
      v[3 + axis] = angle;
      EXPECT_TRUE(is_tilted(to_isometry(SE3::exp(v)))) << axis << ' ' << angle;
    }
  }
}

}  // namespace
}  // namespace hybrid
