// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// The trajectory in TUM format: `timestamp tx ty tz qx qy qz qw` per line (s, m, unit quaternion
/// with qw >= 0), with enough digits to restore the same doubles. `names`, one for each pose, take
/// the place of the stamps, such as ids of vertices that no double holds. The heading starts with
/// `#`.
std::string tum_text(const Trajectory& trajectory, const std::vector<std::string>& names = {});

/// The covariances of the poses, one for each, 3x3 over (x, y, yaw) or 6x6 over (x, y, z, rotation
/// vector), in the axes of the robot: the true pose is T_map_robot Exp(e), e ~ N(0, P) [m, rad].
/// CSV, after the time the rows of the upper triangle; empty cells where one is not known.
std::string covariances_csv(const Trajectory& trajectory,
                            const std::vector<Eigen::MatrixXd>& covariances, bool is_3d);

}  // namespace hybrid
