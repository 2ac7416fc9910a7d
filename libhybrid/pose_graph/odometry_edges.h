// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <unordered_map>

#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// Tells odometry from loop closures: an edge is odometry if its poses follow each other in the
/// order of their ids, in either direction. Ids may skip numbers, but not from one character of
/// GTSAM's symbols (a robot) to the next.
class OdometryEdges {
 public:
  explicit OdometryEdges(const PoseGraph& graph);

  bool operator()(Key from, Key to) const;

 private:
  std::unordered_map<Key, Key> next_;  // of each pose behind which numbers are skipped
};

}  // namespace hybrid
