// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// A graph with the types of g2o.
struct ExportedGraph {
  PoseGraph graph;
  /// Names of factor types of which some factors have no such form, each once.
  std::vector<std::string> left_out;
};

/// Relative poses as they are; sightings as points in the frame of the robot, with their covariance
/// to first order; hybrid factors as the component that the assignment chooses; poses with a prior
/// as fixed. Classes have no form in g2o, nor have variables of other kinds, such as a plugin's
/// own.
ExportedGraph export_graph(const HybridGraph& graph, const Estimate& estimate);

}  // namespace hybrid
