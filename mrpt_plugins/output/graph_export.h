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

/// Converts a graph to g2o. Relative poses stay as they are; sightings become points in the frame
/// of the robot, with their covariance to first order; hybrid factors become the component that the
/// assignment selects; poses with a prior become fixed. Factors of classes have no form in g2o.
ExportedGraph export_graph(const HybridGraph& graph, const Estimate& estimate);

}  // namespace hybrid
