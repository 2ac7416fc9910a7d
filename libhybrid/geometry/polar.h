// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Distances below this [m] are replaced by it in the denominators of derivatives of angles, so
/// that these stay finite at the sensor itself and, for yaw, on its vertical axis.
constexpr double kMinDistance = 1e-6;

/// (range [m], bearing [rad]) of a point, bearing = atan2(y, x). At the origin both are zero, and
/// the derivatives are those of a point just ahead, so that a solver can leave it. `J`, if not
/// null, receives the Jacobian.
Eigen::Vector2d to_polar(const Eigen::Vector2d& p, Eigen::Matrix2d* J = nullptr);

/// (range [m], yaw [rad], pitch [rad]) of a point, yaw = atan2(y, x), pitch = -asin(z / range): a
/// point above the sensor (z > 0) has negative pitch, the convention of
/// mrpt::poses::CPose3D::sphericalCoordinates. At the origin all are zero; on the axis x = y = 0
/// yaw is zero, and the derivatives are those of a point just ahead of the axis.
Eigen::Vector3d to_polar(const Eigen::Vector3d& p, Eigen::Matrix3d* J = nullptr);

/// The point with given polar coordinates: the inverse of `to_polar`.
Eigen::Vector2d from_polar(const Eigen::Vector2d& z, Eigen::Matrix2d* J = nullptr);
Eigen::Vector3d from_polar(const Eigen::Vector3d& z, Eigen::Matrix3d* J = nullptr);

}  // namespace hybrid
