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

// Camera frames: z ahead, x to the right, y down. Robot frames: x ahead, y to the left, z up. The
// functions below convert from camera to robot frames.

/// The pose in a row-major 3x4 matrix in 12 columns of a row from `first` on, in its own axes.
/// Throws Error if its rotation is not one within 1e-3.
mrpt::poses::CPose3D matrix_pose(const TextRow& row, std::size_t first);
/// The same of a rotation and a translation that were read up to word `i` of a row.
mrpt::poses::CPose3D matrix_pose(const Eigen::Matrix3d& R, const Eigen::Vector3d& t,
                                 const TextRow& row, std::size_t i);

/// The pose of one robot frame in another, from that of the camera frames.
mrpt::poses::CPose3D robot_pose(const mrpt::poses::CPose3D& camera);

/// The pose of one robot frame in another, from that of the camera frames: a row-major 3x4 matrix
/// in the 12 columns from `first` on. Throws Error if its rotation is not one within 1e-3.
mrpt::poses::CPose3D robot_pose(const TextRow& row, std::size_t first);

/// The 6x6 tangent covariance over (translation, rotation) in the robot frame.
Matrix6d robot_covariance(const Matrix6d& camera);

/// The point in the robot frame.
Eigen::Vector3d robot_point(const Eigen::Vector3d& camera);

/// Range, yaw and pitch of a point in the frame of the robot [m, rad]. In the plane, the range is
/// the horizontal one and pitch is zero.
CObservationClassedBearingRange::Detection detection_of(const Eigen::Vector3d& point, bool is_3d);

/// The pose with z, pitch and roll left out.
mrpt::poses::CPose3D flattened(const mrpt::poses::CPose3D& pose);

}  // namespace hybrid
