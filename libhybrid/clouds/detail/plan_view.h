// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/clouds/cloud_alignment.h"
#include "libhybrid/scans/scan_points.h"

namespace hybrid {

/// Of a rotation: its turn about the vertical axis [rad].
double yaw_of(const Eigen::Matrix3d& R);
Eigen::Matrix3d turn_about_z(double angle);
/// The rotation of a pose without its heading: it makes axes of the frame level.
Eigen::Matrix3d level_of(const SE3& pose);

/// Turns a frame whose z axis points up roughly, so that it does: floors and ceilings tell. The
/// identity where there are none.
Eigen::Matrix3d levelling(const std::vector<CloudPoint>& points);

/// Walls and poles, seen from above, in a frame turned by `level`.
std::vector<SurfacePoint> walls_of(const std::vector<CloudPoint>& points,
                                   const Eigen::Matrix3d& level);

/// The pose of most surfaces about a start, moved up and down by up to `steps` times `step`.
SE3 at_best_height(const std::vector<CloudPoint>& points, const CloudSurfaces& surfaces,
                   const SE3& start, const Eigen::Vector3d& step, int steps);

}  // namespace hybrid
