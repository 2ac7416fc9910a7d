// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/pose_graph/odometry_edges.h"

#include <utility>
#include <vector>

#include "libhybrid/core/sort_unique.h"
#include "libhybrid/pose_graph/vertex_id.h"

namespace hybrid {

namespace {

/// The characters of a symbol of GTSAM, see vertex_index(); 0 for a plain number.
std::uint64_t characters_of(Key key) {
  const std::uint64_t index = key.index();
  return index <= static_cast<std::uint64_t>(kLargestPlainId) ? 0 : index >> 40U;
}

}  // namespace

OdometryEdges::OdometryEdges(const PoseGraph& graph) {
  std::vector<Key> poses;
  const auto add = [&](const auto& edges) {
    for (const auto& edge : edges) {
      poses.push_back(edge.from);
      poses.push_back(edge.to);
    }
  };
  add(graph.poses2);
  add(graph.poses3);
  for (const Key key : graph.values.keys()) {
    if (is_pose(graph.values.type(key))) poses.push_back(key);
  }
  sort_unique(poses);
  for (std::size_t k = 1; k < poses.size(); ++k) {
    if (poses[k].index() == poses[k - 1].index() + 1) continue;
    if (characters_of(poses[k]) == characters_of(poses[k - 1])) {
      next_.emplace(poses[k - 1], poses[k]);
    }
  }
}

bool OdometryEdges::operator()(Key from, Key to) const {
  const auto [first, second] = std::minmax(from, to);
  if (second.index() == first.index() + 1) return true;
  const auto next = next_.find(first);
  return next != next_.end() && next->second == second;
}

}  // namespace hybrid
