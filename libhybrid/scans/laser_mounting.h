// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/scans/laser_scan.h"

namespace HYBRID_API hybrid {

/// A scan, and the motion of the robot by odometry since the one before, where it is known.
struct MovedScan {
  LaserScan scan;
  std::optional<SE2> motion;
};

/// A planar laser as its scans tell, where the log states it otherwise.
struct LaserMounting {
  /// Field of view to that stated, about the middle ray: scans from places some way apart agree
  /// best so. 1 where none agrees better by three standard deviations.
  double widening = 1;
  double widening_sigma = std::numeric_limits<double>::infinity();
  bool mirrored = false;  ///< the rays go round the other way
  /// Where on the robot the frame is that the log takes for that of the robot, and standard
  /// deviations (x, y [m], angle [rad]): the laser is so much elsewhere than stated.
  SE2 T_robot_stated;
  Eigen::Vector3d sigmas = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  std::string unknown;  ///< what the scans cannot tell, and why; empty if they tell all

  bool is_as_stated() const {
    return widening == 1 && !mirrored && T_robot_stated.translation().isZero(0) &&
           T_robot_stated.angle() == 0;
  }
};

/// The scan as a mounting has it.
LaserScan corrected(LaserScan scan, const LaserMounting& mounting);

/// Measures the field of view by matches of scans alone; sense of rotation and place of the laser
/// by comparing matches with odometry, for a robot that turns. Scans in the order of time, of one
/// laser, so near each other that a match bridges the motion between them.
LaserMounting measure_mounting(const std::vector<MovedScan>& scans);

}  // namespace hybrid
