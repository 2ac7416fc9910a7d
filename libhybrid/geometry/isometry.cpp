// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/geometry/isometry.h"

#include <cmath>

namespace hybrid {
namespace {

/// t + R p.
Eigen::Vector3d carried(const Eigen::Vector3d& t, const Eigen::Matrix3d& R,
                        const Eigen::Vector3d& p) {
  return t + R.col(0) * p.x() + R.col(1) * p.y() + R.col(2) * p.z();
}

/// The angle in [-pi, pi), rounded as mrpt::math::wrapToPi rounds, since angles are exchanged with
/// MRPT.
double wrapped(double angle) {
  const double turned = std::fmod(angle + M_PI, 2 * M_PI);
  return (turned < 0 ? turned + 2 * M_PI : turned) - M_PI;
}

/// R v.
Eigen::Vector3d turned(const Eigen::Matrix3d& R, const Eigen::Vector3d& v) {
  return R.col(0) * v.x() + (R.col(1) * v.y() + R.col(2) * v.z());
}

Eigen::Matrix3d product(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  Eigen::Matrix3d out;
  for (int j = 0; j < 3; ++j) out.col(j) = turned(A, B.col(j));
  return out;
}

Eigen::Isometry3d isometry(const Eigen::Matrix3d& R, const Eigen::Vector3d& t) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = R;
  out.translation() = t;
  return out;
}

}  // namespace

SE2 to_se2(const Eigen::Isometry3d& pose) {
  const auto& R = pose.linear();
  return {pose.translation().x(), pose.translation().y(), std::atan2(R(1, 0), R(0, 0))};
}

SE3 to_se3(const Eigen::Isometry3d& pose) {
  const Eigen::Matrix3d R = pose.linear();
  return {pose.translation(), Eigen::Quaterniond(R).normalized()};
}

Eigen::Isometry3d to_isometry(const SE2& pose) {
  const double yaw = wrapped(pose.angle()), c = std::cos(yaw), s = std::sin(yaw);
  Eigen::Matrix3d R;
  R << c, -s, 0, s, c, 0, 0, 0, 1;
  return isometry(R, {pose.x(), pose.y(), 0});
}

Eigen::Isometry3d to_isometry(const SE3& pose) {
  return isometry(pose.rotation().matrix(), pose.translation());
}

Eigen::Isometry3d compose(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Eigen::Matrix3d R = a.linear();
  return isometry(product(R, b.linear()), carried(a.translation(), R, b.translation()));
}

Eigen::Isometry3d between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
  const Eigen::Matrix3d R = a.linear().transpose();
  const Eigen::Vector3d t = carried(Eigen::Vector3d::Zero(), R, -a.translation());
  return isometry(product(R, b.linear()), carried(t, R, b.translation()));
}

Eigen::Vector3d direction(double yaw, double pitch) {
  const double y = wrapped(yaw), p = wrapped(pitch);
  return {std::cos(y) * std::cos(p), std::sin(y) * std::cos(p), -std::sin(p)};
}

Eigen::Vector3d rotated(const Eigen::Isometry3d& T, const Eigen::Vector3d& v) {
  return turned(T.linear(), v);
}

SE3::Jacobian adjoint(const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d R = T.linear();
  SE3::Jacobian out = SE3::Jacobian::Zero();
  out.topLeftCorner<3, 3>() = R;
  out.bottomRightCorner<3, 3>() = R;
  out.topRightCorner<3, 3>() = hat(T.translation()) * R;
  return out;
}

bool is_tilted(const Eigen::Isometry3d& pose) {
  constexpr double kTolerance = 1e-9;  // rad
  const auto& R = pose.linear();
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  const double roll = std::atan2(R(2, 1), R(2, 2));
  return std::abs(pitch) > kTolerance || std::abs(roll) > kTolerance;
}

}  // namespace hybrid
