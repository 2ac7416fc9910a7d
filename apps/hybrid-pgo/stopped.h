// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "apps/hybrid-pgo/solution.h"
#include "libhybrid/pose_graph/pose_feed.h"

namespace hybrid {

/// Notes that a signal stopped the solver before it had all poses. Throws Interrupted if it had
/// none.
void stopped(const PoseFeed& feed, Solution& solution);

/// A solution that was stopped has only some of the poses: keeps these of the graph, with the
/// measurements between them, and renumbers what the solution says of measurements.
void keep_solved(Input& input, Solution& solution);

}  // namespace hybrid
