// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "libhybrid/export.h"
#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// One sweep of a planar laser range finder.
struct LaserScan {
  double time = 0;  ///< of the sweep [s]
  /// Distances [m] in the order of the rays; NaN where a ray has no return, be it invalid, zero or
  /// at the maximum range.
  std::vector<float> ranges;
  double first_angle =
      0;                  ///< of the first ray [rad], counter-clockwise, in the frame of the sensor
  double angle_step = 0;  ///< between two rays [rad]; negative where the sweep is clockwise
  double max_range = 80;  ///< beyond which the sensor sees nothing [m]
  Eigen::Isometry3d T_robot_sensor = Eigen::Isometry3d::Identity();
  /// Where the robot was at the time of the sweep, in the frame of the keyframe that the scan is
  /// given to, as odometry tells; identity for the scan at the keyframe itself.
  Eigen::Isometry3d T_keyframe_robot = Eigen::Isometry3d::Identity();
};

}  // namespace hybrid
