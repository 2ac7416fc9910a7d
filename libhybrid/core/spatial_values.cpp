// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/spatial_values.h"

namespace hybrid {

Eigen::Isometry3d isometry_at(const Values& values, Key key) {
  if (values.type(key).kind == VariableKind::kSE2) return to_isometry(values.at<SE2>(key));
  return to_isometry(values.at<SE3>(key));
}

Eigen::Vector3d point_at(const Values& values, Key key) {
  if (values.type(key).dim == 3) return values.at<Eigen::Vector3d>(key);
  return padded_point(values.at<Eigen::Vector2d>(key));
}

Eigen::Vector3d padded_point(const Eigen::VectorXd& point) {
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  out.head(point.size()) = point;
  return out;
}

void insert_pose(Values& values, Key key, const Eigen::Isometry3d& pose, bool is_3d) {
  if (is_3d) {
    values.insert(key, to_se3(pose));
  } else {
    values.insert(key, to_se2(pose));
  }
}

void insert_point(Values& values, Key key, const Eigen::Vector3d& point, bool is_3d) {
  if (is_3d) {
    values.insert(key, point);
  } else {
    values.insert(key, Eigen::Vector2d(point.head<2>()));
  }
}

}  // namespace hybrid
