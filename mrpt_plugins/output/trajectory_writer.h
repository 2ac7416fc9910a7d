// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// The trajectory in TUM format: `timestamp tx ty tz qx qy qz qw` per line (s, m, unit quaternion
/// with qw >= 0), with enough digits to restore the same doubles. The heading starts with `#`.
std::string tum_text(const Trajectory& trajectory);

/// The trajectory in KITTI format: the first three rows of T_map_robot, row by row, 12 numbers per
/// line.
std::string kitti_text(const Trajectory& trajectory);

}  // namespace hybrid
