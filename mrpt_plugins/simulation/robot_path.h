// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <vector>

#include "mrpt_plugins/simulation/scenario.h"

namespace HYBRID_API hybrid {

/// True poses of the robot, one per frame; the first is the origin. In 3-D, the height follows
/// height/2 (1 - cos) and the roll a sine along the path; the pitch follows the slope.
std::vector<mrpt::poses::CPose3D> robot_path(const Scenario::Path& path, bool is_3d);

}  // namespace hybrid
