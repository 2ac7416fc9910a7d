// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/pose_conversions.h"

#include <mrpt/math/CMatrixFixed.h>

#include <cmath>

namespace hybrid {

Eigen::Isometry3d to_isometry(const mrpt::poses::CPose3D& pose) {
  Eigen::Isometry3d out = Eigen::Isometry3d::Identity();
  out.linear() = pose.getRotationMatrix().asEigen();
  out.translation() << pose.x(), pose.y(), pose.z();
  return out;
}

SE2 to_se2(const mrpt::poses::CPose3D& pose) {
  return {pose.x(), pose.y(), pose.yaw()};
}

SE3 to_se3(const mrpt::poses::CPose3D& pose) {
  const Eigen::Matrix3d R = pose.getRotationMatrix().asEigen();
  return {Eigen::Vector3d(pose.x(), pose.y(), pose.z()), Eigen::Quaterniond(R).normalized()};
}

mrpt::poses::CPose3D to_mrpt(const SE2& pose) {
  return {pose.x(), pose.y(), 0.0, pose.angle(), 0.0, 0.0};
}

mrpt::poses::CPose3D to_mrpt(const SE3& pose) {
  return to_mrpt(to_isometry(pose));
}

mrpt::poses::CPose3D to_mrpt(const Eigen::Isometry3d& pose) {
  mrpt::math::CMatrixDouble33 R;
  R.asEigen() = pose.linear();
  const Eigen::Vector3d t = pose.translation();
  mrpt::poses::CPose3D out(t.x(), t.y(), t.z());
  out.setRotationMatrix(R);
  return out;
}

mrpt::poses::CPose3D pose_at(const Values& values, Key key) {
  if (values.type(key).kind == VariableKind::kSE2) return to_mrpt(values.at<SE2>(key));
  return to_mrpt(values.at<SE3>(key));
}

Eigen::Vector3d point_of(const mrpt::poses::CPose3D& pose) {
  return {pose.x(), pose.y(), pose.z()};
}

void insert_pose(Values& values, Key key, const mrpt::poses::CPose3D& pose, bool is_3d) {
  if (is_3d) {
    values.insert(key, to_se3(pose));
  } else {
    values.insert(key, to_se2(pose));
  }
}

bool is_tilted(const mrpt::poses::CPose3D& pose) {
  constexpr double kTolerance = 1e-9;
  return std::abs(pose.pitch()) > kTolerance || std::abs(pose.roll()) > kTolerance;
}

Eigen::Vector3d transformed(const mrpt::poses::CPose3D& pose, const Eigen::Vector3d& point) {
  const auto p = pose.composePoint({point.x(), point.y(), point.z()});
  return {p.x, p.y, p.z};
}

Eigen::Vector3d seen_from(const mrpt::poses::CPose3D& pose, const Eigen::Vector3d& point) {
  const auto p = pose.inverseComposePoint({point.x(), point.y(), point.z()});
  return {p.x, p.y, p.z};
}

}  // namespace hybrid
