// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Geometry>

#include "libhybrid/core/values.h"
#include "libhybrid/geometry/isometry.h"

/// Poses and points of a map in the plane (SE2, vectors of 2) or in space (SE3, vectors of 3) as
/// poses and points in space: for those in the plane z, pitch and roll are zero.
namespace HYBRID_API hybrid {

/// The pose variable `key`; throws Error unless it is SE2 or SE3.
Eigen::Isometry3d isometry_at(const Values& values, Key key);

/// The point variable `key`; throws Error unless it is a vector of 2 (then z = 0) or 3.
Eigen::Vector3d point_at(const Values& values, Key key);

/// A point of 2 (then z = 0) or 3 coordinates.
Eigen::Vector3d padded_point(const Eigen::VectorXd& point);

/// Adds a pose as SE3 or, with its x, y and yaw, as SE2.
void insert_pose(Values& values, Key key, const Eigen::Isometry3d& pose, bool is_3d);

/// Adds a point with all three coordinates or with x and y.
void insert_point(Values& values, Key key, const Eigen::Vector3d& point, bool is_3d);

}  // namespace hybrid
