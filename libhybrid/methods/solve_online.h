// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/online/online_selection.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// Solves a pose graph pose by pose, with OnlineSelection on its closures; decisions are in the
/// order of `to_robust_problem`, which says what an empty `trusted` means. `initial` holds the
/// first pose. Throws Error if the trusted measurements do not connect a pose to those before it.
RobustResult solve_online(const PoseGraph& graph, const Values& initial, const Trust& trusted = {},
                          const OnlineSelectionOptions& options = {});

}  // namespace hybrid
