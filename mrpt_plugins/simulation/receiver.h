// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/simulation/scenario.h"

namespace HYBRID_API hybrid {

/// What a receiver of satellites says, and what of it is wrong.
struct SimulatedFix {
  double time = 0;        ///< its stamp, since the first frame [s]
  std::size_t frame = 0;  ///< the first that is not before
  FixMode mode = FixMode::kGood;
  GeodeticPoint place;
  Eigen::Vector3d error = Eigen::Vector3d::Zero();  ///< east, north, up [m]
};

/// Draws the fixes along a path, which has a pose per frame. Their random numbers are their own, so
/// that a receiver changes nothing else.
std::vector<SimulatedFix> draw_fixes(const Scenario& scenario,
                                     const std::vector<mrpt::poses::CPose3D>& path);

}  // namespace hybrid
