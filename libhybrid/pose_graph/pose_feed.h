// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <functional>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "libhybrid/pose_graph/pose_graph.h"

namespace HYBRID_API hybrid {

/// Replays a graph pose by pose, as a robot would have measured it: each pose comes with the
/// measurements between it and earlier poses and with its sightings of landmarks. Poses come in the
/// order of their ids, except that a pose waits until a measurement connects it to an earlier one.
/// Parts that nothing connects but that are measured in the map follow each other. Where only
/// positions are measured there, a part begins with as many poses at once as it takes to tell where
/// it lies.
class PoseFeed {
 public:
  using Neighbours = std::unordered_map<Key, std::vector<Key>>;

  /// The factors are those of `to_factors` with the same arguments. Measurements that may be false
  /// do not connect: `connects` tells by the number of the factor. The graph must outlive the feed.
  /// Throws Error naming vertices that no measurement connects to the first pose or to the map.
  PoseFeed(const PoseGraph& graph, const Values& initial, const GraphFactorOptions& options = {},
           const std::function<bool(std::size_t factor)>& connects = {});

  std::size_t steps() const { return ends_.size(); }
  bool done() const { return next_ == ends_.size(); }
  /// The pose that the next step adds, or the last one of several. Throws Error if all are done.
  Key pose() const;
  /// Number of poses added so far.
  std::size_t added() const { return next_ == 0 ? 0 : ends_[next_ - 1]; }

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

  void split_into_steps(std::size_t begin);
  void place_factors(const Neighbours& neighbours, Key first);

  const PoseGraph& graph_;
  OdometryEdges is_odometry_;
  Values initial_;
  std::vector<ContinuousFactorPtr> factors_;
  std::vector<bool> connects_;  // by factor
  std::vector<Key> poses_;
  std::vector<std::size_t> ends_;   // by step: behind its last pose in poses_
  std::unordered_set<Key> starts_;  // poses of the first steps of parts, which begin where they are
  std::vector<HybridFactorPtr> hypotheses_;           // by edge; null for a plain one
  std::vector<std::vector<std::size_t>> factors_of_;  // by step, indices into factors_
  std::size_t next_ = 0;
};

}  // namespace hybrid
