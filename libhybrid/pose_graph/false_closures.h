// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstdint>

#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// A copy of a graph with false closures appended to its edges, by the protocol of section V-A:
/// between random pairs of poses that are not neighbours, translation uniform in a cube (square in
/// the plane) of side 10 m, rotation uniform. Their number makes up the share `rate` in [0, 1) of
/// all closures, so a graph without closures gets none; each has the noise of a random true
/// closure. The same on every machine for the same seed. Throws Error for a rate out of range or a
/// graph of fewer than three poses.
PoseGraph add_false_closures(const PoseGraph& graph, double rate, std::uint64_t seed);

}  // namespace hybrid
