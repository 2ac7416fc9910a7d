// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <cstddef>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/observations/classed_bearing_range.h"

namespace hybrid {

// Cameras look along z with x to the right and y down; robots look along x with y to the left and z
// up. The functions below change from the first to the second.

/// A row-major 3x4 matrix in the columns from `first` on: a pose of one camera frame in another, as
/// the pose of one robot frame in another. Throws Error if it is not a rotation within 1e-3.
mrpt::poses::CPose3D robot_pose(const TextRow& row, std::size_t first);

/// The 6x6 tangent covariance over (translation, rotation).
Matrix6d robot_covariance(const Matrix6d& camera);

/// A point.
Eigen::Vector3d robot_point(const Eigen::Vector3d& camera);

/// Range, yaw and pitch of a point in the frame of the robot [m]. In the plane the range is that of
/// the point's foot, and pitch is zero.
CObservationClassedBearingRange::Detection detection_of(const Eigen::Vector3d& point, bool is_3d);

/// The pose with z, pitch and roll left out.
mrpt::poses::CPose3D flattened(const mrpt::poses::CPose3D& pose);

}  // namespace hybrid
