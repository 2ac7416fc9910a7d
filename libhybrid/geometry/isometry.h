// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Geometry>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"

/// Poses of robots and sensors as rotation matrix and translation, whether they move in the plane
/// or in space. Sums run in one fixed order, so that results do not depend on the processor.
namespace HYBRID_API hybrid {

/// x, y and yaw of a pose.
SE2 to_se2(const Eigen::Isometry3d& pose);
SE3 to_se3(const Eigen::Isometry3d& pose);
Eigen::Isometry3d to_isometry(const SE2& pose);
Eigen::Isometry3d to_isometry(const SE3& pose);

/// a b.
Eigen::Isometry3d compose(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);
/// a^-1 b.
Eigen::Isometry3d between(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b);

/// The unit vector at yaw and pitch [rad]; positive pitch points down.
Eigen::Vector3d direction(double yaw, double pitch);
/// R v, for R the rotation of T.
Eigen::Vector3d rotated(const Eigen::Isometry3d& T, const Eigen::Vector3d& v);

/// T Exp(v) = Exp(adjoint(T) v) T for tangents (translation, rotation).
SE3::Jacobian adjoint(const Eigen::Isometry3d& T);

/// Whether a pose has pitch or roll.
bool is_tilted(const Eigen::Isometry3d& pose);

}  // namespace hybrid
