// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// For each relative pose of a graph, in the order of to_factors, whether it is odometry that says
/// nothing: in some direction its standard deviation is more than a thousand times that of most
/// odometry, and more than half a turn or the whole way of the odometry. Such an edge stands for a
/// break, as where a robot was carried. What a break divides are two parts, which closures that
/// agree join; the edge is one of these. Its information is raised to that of these limits, with
/// which a map that it alone holds together can be factorised.
std::vector<bool> bound_breaks(PoseGraph& graph);

}  // namespace hybrid
