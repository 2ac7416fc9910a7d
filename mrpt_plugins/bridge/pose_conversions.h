// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <Eigen/Core>

#include "libhybrid/core/spatial_values.h"

namespace HYBRID_API hybrid {

/// Conversions between MRPT's poses and those of the library, in the plane or in space.
Eigen::Isometry3d to_isometry(const mrpt::poses::CPose3D& pose);
SE2 to_se2(const mrpt::poses::CPose3D& pose);
SE3 to_se3(const mrpt::poses::CPose3D& pose);
mrpt::poses::CPose3D to_mrpt(const SE2& pose);
mrpt::poses::CPose3D to_mrpt(const SE3& pose);
mrpt::poses::CPose3D to_mrpt(const Eigen::Isometry3d& pose);

/// The pose variable `key`, of type SE2 or SE3.
mrpt::poses::CPose3D pose_at(const Values& values, Key key);

/// Position of a pose [m].
Eigen::Vector3d point_of(const mrpt::poses::CPose3D& pose);

/// A point in the frame of a pose, in the frame in which the pose is given; and the inverse.
Eigen::Vector3d transformed(const mrpt::poses::CPose3D& pose, const Eigen::Vector3d& point);
Eigen::Vector3d seen_from(const mrpt::poses::CPose3D& pose, const Eigen::Vector3d& point);

/// Inserts a pose as SE3 or, by its x, y and yaw, as SE2.
void insert_pose(Values& values, Key key, const mrpt::poses::CPose3D& pose, bool is_3d);

/// Whether the pitch or roll of a pose is not zero.
bool is_tilted(const mrpt::poses::CPose3D& pose);

}  // namespace hybrid
