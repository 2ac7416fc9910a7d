// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "mrpt_plugins/simulation/moving_things.h"
#include "mrpt_plugins/simulation/random.h"
#include "mrpt_plugins/simulation/scenario.h"

namespace HYBRID_API hybrid {

/// What a planar laser at a pose sees of walls, glass and, as discs, of things that move at a
/// frame: a range for each ray with noise [m], 0 where there is no return. In 2-D.
std::vector<float> simulated_scan(const Scenario::Laser& laser,
                                  const mrpt::poses::CPose3D& T_map_sensor,
                                  const std::vector<SimulatedMover>& movers, std::size_t frame,
                                  Random& random);

}  // namespace hybrid
