// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/contribution.h"

#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/isometry.h"

namespace hybrid {

void enter(const Contribution& contribution, LandmarkRegistry& landmarks) {
  for (const Landmark& landmark : contribution.landmarks) landmarks.add(landmark);
  for (const std::int64_t id : contribution.sighted) landmarks.sighted(id);
  for (const std::int64_t id : contribution.unsighted) landmarks.unsighted(id);
  for (const std::int64_t id : contribution.forgotten) landmarks.remove(id);
}

Eigen::MatrixXd covariance_of_motion(const KeyframeView& frame, Key before, const MapView& map) {
  if (!map.holds(before)) return frame.joint_covariance({});
  const Eigen::Isometry3d T_now_before =
      between(frame.T_map_robot, isometry_at(map.values, before));
  if (map.is_3d) return covariance_of_motion(frame, before, adjoint(T_now_before));
  return covariance_of_motion(frame, before, to_se2(T_now_before).adjoint());
}

Eigen::MatrixXd covariance_of_motion(const KeyframeView& frame, Key before,
                                     const Eigen::MatrixXd& adjoint) {
  const Eigen::Index n = adjoint.rows();
  Eigen::MatrixXd J(n, 2 * n);  // the newest pose comes first
  J << Eigen::MatrixXd::Identity(n, n), -adjoint;
  return frame.covariance_of({before}, J);
}

}  // namespace hybrid
