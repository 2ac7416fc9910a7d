// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "apps/hybrid-pgo/solution.h"
#include "libhybrid/pose_graph/pose_feed.h"

namespace hybrid {

/// Records in the solution that a signal stopped the solver before the last pose. Throws
/// Interrupted if there is no pose yet.
void stopped(const PoseFeed& feed, Solution& solution);

/// Reduces the graph to the poses of a solution that was stopped, with the measurements between
/// them, and renumbers the measurements in the solution.
void keep_solved(Input& input, Solution& solution);

}  // namespace hybrid
