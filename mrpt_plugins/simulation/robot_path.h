// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <string>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Where a robot goes. Lengths in metres, angles in radians, times in seconds.
struct DrivenPath {
  std::string shape;
  int laps = 1;
  double step = 0, max_turn = 0, period = 0;
  double radius = 0;                       // circle
  double width = 0, lane_spacing = 0;      // lawnmower
  int lanes = 0;                           // lawnmower
  std::vector<double> waypoints;           // x y x y ...
  double height = 0, waves = 0, roll = 0;  // in 3-D
  mrpt::poses::CPose3D start;
};

/// True poses of the robot, one per frame; the first is the origin. In 3-D, the height follows
/// height/2 (1 - cos) and the roll a sine along the path; the pitch follows the slope.
std::vector<mrpt::poses::CPose3D> robot_path(const DrivenPath& path, bool is_3d);

}  // namespace hybrid
