// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A pose of the robot in the map, T_map_robot, at a time in seconds.
struct TimedPose {
  double time = 0;
  mrpt::poses::CPose3D pose;
};

/// Poses in the order of time.
using Trajectory = std::vector<TimedPose>;

}  // namespace hybrid
