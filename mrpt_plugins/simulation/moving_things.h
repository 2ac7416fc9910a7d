// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <vector>

#include "mrpt_plugins/simulation/random.h"
#include "mrpt_plugins/simulation/scenario.h"

namespace HYBRID_API hybrid {

/// A thing that moves in the box of the world, at its height.
struct SimulatedMover {
  std::int64_t id = 0;
  std::size_t class_index = 0;
  std::vector<std::array<double, 3>> path;  ///< position at each frame [m]
};

/// Draws `frames` positions of each mover: it keeps its velocity but for white noise of
/// acceleration, and turns back at the walls of the box. Ids follow those of the landmarks.
std::vector<SimulatedMover> draw_movers(const Scenario& scenario, std::size_t frames,
                                        Random& random);

}  // namespace hybrid
