// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/pose_graph/odometry_edges.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// Replays a graph pose by pose, as a robot would have measured it: each pose comes with the
/// measurements between it and earlier poses and with its sightings of landmarks. Poses come in the
/// order of their ids, except that a pose waits until a measurement connects it to an earlier one.
class PoseFeed {
 public:
  /// The factors are those of `to_factors` with the same arguments. The graph must outlive the
  /// feed. Throws Error naming vertices that no measurement connects to the first pose.
  PoseFeed(const PoseGraph& graph, const Values& initial, const GraphFactorOptions& options = {});

  std::size_t steps() const { return poses_.size(); }
  bool done() const { return next_ == poses_.size(); }
  /// The pose that the next step adds. Throws Error if all are done.
  Key pose() const;

  /// The factors of `to_factors`, to which `next` returns pointers.
  const std::vector<ContinuousFactorPtr>& factors() const { return factors_; }

  /// The next pose with its factors; an edge with hypotheses comes as their mixture. The initial
  /// value of the pose is from its first measurement, odometry preferred, and the estimate of the
  /// poses so far; that of a landmark is from its first sighting. Throws Error if all are done.
  Delta next(const Values& estimate);

 private:
  template <class Pose>
  bool predict(const GraphEdge<Pose>& edge, const Values& estimate, Values& fresh) const;
  template <class Pose>
  void start_pose(const std::vector<GraphEdge<Pose>>& edges, std::size_t first,
                  const Values& estimate, Values& fresh) const;
  template <class Pose>
  void start_landmarks(const std::vector<GraphEdge<typename Pose::Point>>& edges, std::size_t first,
                       const Values& estimate, Values& fresh) const;

  const PoseGraph& graph_;
  OdometryEdges is_odometry_;
  Values initial_;
  std::vector<ContinuousFactorPtr> factors_;
  std::vector<Key> poses_;
  std::vector<HybridFactorPtr> hypotheses_;           // by edge; null for a plain one
  std::vector<std::vector<std::size_t>> factors_of_;  // by step, indices into factors_
  std::size_t next_ = 0;
};

}  // namespace hybrid
