// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detail/camera.h"

#include <Eigen/Dense>
#include <cmath>

namespace hybrid {
namespace {

Eigen::Matrix3d robot_from_camera() {
  return (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
}

}  // namespace

mrpt::poses::CPose3D matrix_pose(const Eigen::Matrix3d& R, const Eigen::Vector3d& t,
                                 const TextRow& row, std::size_t i) {
  if (!(R * R.transpose()).isIdentity(1e-3) || R.determinant() < 0) {
    row.fail(i, "the left 3x3 block is not a rotation");
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(R, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d rotation = svd.matrixU() * svd.matrixV().transpose();
  return {mrpt::math::CMatrixDouble33(rotation),
          mrpt::math::CVectorFixedDouble<3>(mrpt::math::TPoint3D(t.x(), t.y(), t.z()))};
}

mrpt::poses::CPose3D matrix_pose(const TextRow& row, std::size_t first) {
  Eigen::Matrix3d R;
  Eigen::Vector3d t;
  for (Eigen::Index r = 0; r < 3; ++r) {
    const std::size_t column = first + 4 * static_cast<std::size_t>(r);
    for (Eigen::Index c = 0; c < 3; ++c) R(r, c) = row.number(column + static_cast<std::size_t>(c));
    t[r] = row.coordinate(column + 3);
  }
  return matrix_pose(R, t, row, first);
}

mrpt::poses::CPose3D robot_pose(const mrpt::poses::CPose3D& camera) {
  const mrpt::poses::CPose3D turn(mrpt::math::CMatrixDouble33(robot_from_camera()),
                                  mrpt::math::CVectorFixedDouble<3>(mrpt::math::TPoint3D(0, 0, 0)));
  return turn + camera + (-turn);
}

mrpt::poses::CPose3D robot_pose(const TextRow& row, std::size_t first) {
  row.expect(first + 12, "a 3x4 matrix, row by row");
  return robot_pose(matrix_pose(row, first));
}

Matrix6d robot_covariance(const Matrix6d& camera) {
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = J.bottomRightCorner<3, 3>() = robot_from_camera();
  return J * camera * J.transpose();
}

Eigen::Vector3d robot_point(const Eigen::Vector3d& camera) {
  return robot_from_camera() * camera;
}

CObservationClassedBearingRange::Detection detection_of(const Eigen::Vector3d& point, bool is_3d) {
  CObservationClassedBearingRange::Detection d;
  const double flat = point.head<2>().norm();
  d.range = static_cast<float>(is_3d ? point.norm() : flat);
  d.yaw = static_cast<float>(std::atan2(point.y(), point.x()));
  d.pitch = static_cast<float>(is_3d ? -std::atan2(point.z(), flat) : 0.0);
  return d;
}

mrpt::poses::CPose3D flattened(const mrpt::poses::CPose3D& pose) {
  return {pose.x(), pose.y(), 0, pose.yaw(), 0, 0};
}

}  // namespace hybrid
