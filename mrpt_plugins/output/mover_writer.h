// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// Trajectories of things that move as CSV with a heading, a line for each keyframe at which a
/// thing was in sight: id, probability that it moves, class (empty if none), sightings, keyframe,
/// time (s), position (m) and velocity (m/s) in the frame of the map, and the upper triangles of
/// their covariances (m^2, m^2/s^2), given the path of the robot.
std::string movers_csv(const MapResult& result);

}  // namespace hybrid
