// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/poses.h"

#include <gtest/gtest.h>
#include <mrpt/poses/Lie/SO.h>

#include <random>

#include "libhybrid/detections/sighting.h"
#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;
using Vector6d = Eigen::Matrix<double, 6, 1>;

const CPose3D kPoses[] = {{1, -2, 3, 0.4, -0.7, 1.9}, {0, 0, 0, 0, 0, 0}, {5, 1, 0, -2.5, 0.2, -3}};

CPose3D exp(const Vector6d& xi) {
  CPose3D T(xi[0], xi[1], xi[2], 0, 0, 0);
  T.setRotationMatrix(mrpt::poses::Lie::SO<3>::exp(
      mrpt::math::CVectorFixedDouble<3>(Eigen::Vector3d(xi.tail<3>()))));
  return T;
}

Vector6d log(const CPose3D& T) {
  Vector6d xi;
  xi << T.x(), T.y(), T.z(), mrpt::poses::Lie::SO<3>::log(T.getRotationMatrix()).asEigen();
  return xi;
}

Vector6d euler(const CPose3D& T) {
  return (Vector6d() << T.x(), T.y(), T.z(), T.yaw(), T.pitch(), T.roll()).finished();
}

CPose3D from_euler(const Vector6d& e) {
  return {e[0], e[1], e[2], e[3], e[4], e[5]};
}

TEST(Poses, EulerJacobianMatchesDifferences) {
  for (const CPose3D& T : kPoses) {
    Matrix6d numeric;
    for (int i = 0; i < 6; ++i) {
      const Vector6d step = 1e-6 * Vector6d::Unit(i);
      const CPose3D up = from_euler(euler(T) + step), down = from_euler(euler(T) - step);
      numeric.col(i) = (log(up - T) - log(down - T)) / 2e-6;
    }
    EXPECT_TRUE(tangent_from_euler(T).isApprox(numeric, 1e-8)) << T;
    EXPECT_TRUE((tangent_from_euler(T) * euler_from_tangent(T)).isIdentity(1e-12)) << T;
  }
}

TEST(Poses, AdjointMovesPerturbationToTheLeft) {
  for (const CPose3D& T : kPoses) {
    for (int i = 0; i < 6; ++i) {
      const Vector6d xi = 1e-6 * Vector6d::Unit(i);
      const CPose3D conjugate = T + exp(xi) + (-T);
      EXPECT_LT((log(conjugate) - adjoint(T) * xi).norm(), 1e-10) << T;
    }
  }
}

TEST(Poses, CovarianceRoundTripAndOrder) {
  Matrix6d A = Matrix6d::Random();
  mrpt::poses::CPose3DPDFGaussian pdf(
      kPoses[0], mrpt::math::CMatrixDouble66(Matrix6d(A * A.transpose() + Matrix6d::Identity())));
  const auto back = pose_pdf(pdf.mean, tangent_covariance(pdf));
  EXPECT_TRUE(back.cov.asEigen().isApprox(pdf.cov.asEigen(), 1e-10));

  // At the identity, MRPT's yaw (index 3) is our rotation about z (index 5).
  mrpt::poses::CPose3DPDFGaussian plain;
  plain.cov.setZero();
  plain.cov(3, 3) = 7;
  plain.cov(5, 5) = 2;
  const Matrix6d ours = tangent_covariance(plain);
  EXPECT_DOUBLE_EQ(ours(5, 5), 7);
  EXPECT_DOUBLE_EQ(ours(3, 3), 2);
}

TEST(Poses, PlanarCovarianceIsThatOfTheSpatialPose) {
  Eigen::Matrix3d C;
  C << 0.04, 0.01, 0.002, 0.01, 0.09, -0.003, 0.002, -0.003, 0.01;
  const mrpt::poses::CPosePDFGaussian planar({1, 2, 0.8}, mrpt::math::CMatrixDouble33(C));
  mrpt::poses::CPose3DPDFGaussian spatial;
  spatial.copyFrom(planar);
  const Matrix6d full = tangent_covariance(spatial);
  EXPECT_TRUE(planar_part(full).isApprox(tangent_covariance(planar), 1e-12));
  EXPECT_TRUE(planar_to_6d(planar_part(full)).isApprox(full, 1e-12));
}

// Logs give the same map to the last bit, whichever of the two composes their poses.
TEST(Poses, ThoseOfTheLibraryComposeLikeMrpts) {
  std::mt19937 random(3);
  const auto uniform = [&] { return std::uniform_real_distribution<double>(-1, 1)(random); };
  const auto pose = [&](bool is_flat) {
    const double scale = is_flat ? 0 : 1;
    return CPose3D(100 * uniform(), 100 * uniform(), 10 * scale * uniform(), 3.1 * uniform(),
                   scale * uniform(), scale * uniform());
  };
  const auto same = [](const Eigen::Isometry3d& ours, const CPose3D& theirs) {
    return ours.matrix() == to_isometry(theirs).matrix();
  };
  for (int i = 0; i < 1000; ++i) {
    const CPose3D a = pose(i % 2 == 0), b = pose(i % 2 == 0);
    const Eigen::Isometry3d A = to_isometry(a), B = to_isometry(b);
    ASSERT_TRUE(same(A, to_mrpt(A)));
    ASSERT_TRUE(same(compose(A, B), a + b));
    ASSERT_TRUE(same(between(A, B), b - a));
    ASSERT_EQ(is_tilted(A), is_tilted(a));
    const SE2 ours = to_se2(compose(A, B)), theirs = to_se2(a + b);
    ASSERT_EQ(ours.translation(), theirs.translation());
    ASSERT_EQ(ours.angle(), theirs.angle());
    ASSERT_EQ(to_se3(A).matrix(), to_se3(a).matrix());
    DetectionFrame frame;
    frame.T_robot_sensor = B;
    Detection d;
    d.range = 20 + 20 * uniform();
    d.yaw = 3 * uniform();
    d.pitch = uniform();
    const auto p = (a + b + CPose3D(0, 0, 0, d.yaw, d.pitch, 0)).composePoint({d.range, 0, 0});
    ASSERT_EQ(sighted_point(A, frame, d), Eigen::Vector3d(p.x, p.y, p.z));
  }
}

}  // namespace
}  // namespace hybrid
