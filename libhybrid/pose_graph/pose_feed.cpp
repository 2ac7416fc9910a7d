// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/pose_graph/pose_feed.h"

#include <algorithm>
#include <functional>
#include <queue>
#include <string>
#include <unordered_map>

#include "libhybrid/core/key_letters.h"

namespace hybrid {
namespace {

using Neighbours = std::unordered_map<Key, std::vector<Key>>;

bool is_pose(Key key) {
  return key.letter() == key_letter::kPose;
}

/// For each vertex, those that share a measurement with it.
Neighbours connections(const std::vector<ContinuousFactorPtr>& factors) {
  Neighbours neighbours;
  for (const auto& factor : factors) {
    for (Key a : factor->keys()) {
      std::vector<Key>& list = neighbours[a];
      for (Key b : factor->keys()) {
        if (a != b) list.push_back(b);
      }
    }
  }
  return neighbours;
}

/// Poses from `first` on; the next one is always that of smallest id that a measurement connects to
/// earlier ones.
std::vector<Key> pose_order(Key first, const Neighbours& neighbours) {
  std::vector<Key> order;
  std::unordered_map<Key, bool> seen{{first, true}};
  std::priority_queue<Key, std::vector<Key>, std::function<bool(Key, Key)>> reachable(
      [](Key a, Key b) { return b < a; });
  reachable.push(first);
  while (!reachable.empty()) {
    const Key pose = reachable.top();
    reachable.pop();
    order.push_back(pose);
    for (Key other : neighbours.at(pose)) {
      if (is_pose(other) && seen.emplace(other, true).second) reachable.push(other);
    }
  }
  return order;
}

/// The pose of the first prior on a pose or, if only landmarks have priors, the one of smallest id.
Key first_pose(const std::vector<ContinuousFactorPtr>& factors, std::size_t priors,
               const Neighbours& neighbours) {
  for (std::size_t f = priors; f < factors.size(); ++f) {
    if (is_pose(factors[f]->keys()[0])) return factors[f]->keys()[0];
  }
  Key first{key_letter::kPose, ~std::uint64_t{0}};
  for (const auto& [key, list] : neighbours) {
    if (is_pose(key)) first = std::min(first, key);
  }
  return first;
}

void check_reached(const Neighbours& neighbours, const std::unordered_map<Key, std::size_t>& step,
                   Key first) {
  std::vector<Key> missing;
  for (const auto& [key, list] : neighbours) {
    if (step.count(key) == 0) missing.push_back(key);
  }
  if (missing.empty()) return;
  const Key key = *std::min_element(missing.begin(), missing.end());
  throw Error("no measurement connects vertex " + std::to_string(key.index()) + " to vertex " +
              std::to_string(first.index()) + " (" + std::to_string(missing.size()) +
              " such vertices in all)");
}

}  // namespace

PoseFeed::PoseFeed(const PoseGraph& graph, const Values& initial, const GraphFactorOptions& options)
    : graph_(graph),
      is_odometry_(graph),
      initial_(initial),
      factors_(to_factors(graph, initial, options)) {
  if (factors_.empty()) return;
  hypotheses_.resize(factors_.size());
  const std::size_t planar = graph.alternatives2.size();
  for (std::size_t i = 0; i < graph.alternatives_count(); ++i) {
    const std::size_t edge = i < planar
                                 ? graph.alternatives2[i].edge
                                 : graph.poses2.size() + graph.alternatives3[i - planar].edge;
    hypotheses_[edge] = make_hypotheses(graph, i, options);
  }
  const Neighbours neighbours = connections(factors_);
  const Key first = first_pose(factors_, graph.edge_count(), neighbours);
  poses_ = pose_order(first, neighbours);
  factors_of_.resize(poses_.size());
  std::unordered_map<Key, std::size_t> step;
  for (std::size_t k = 0; k < poses_.size(); ++k) step.emplace(poses_[k], k);
  const std::size_t sightings = graph.poses2.size() + graph.poses3.size();
  for (std::size_t f = sightings; f < graph.edge_count(); ++f) {
    const auto from = step.find(factors_[f]->keys()[0]);
    if (from == step.end()) continue;
    const auto [it, fresh] = step.emplace(factors_[f]->keys()[1], from->second);
    if (!fresh) it->second = std::min(it->second, from->second);
  }
  check_reached(neighbours, step, first);
  for (std::size_t f = 0; f < factors_.size(); ++f) {
    std::size_t last = 0;
    for (Key key : factors_[f]->keys()) last = std::max(last, step.at(key));
    factors_of_[last].push_back(f);
  }
}

/// Adds the unknown end of an edge, predicted from the known end; false unless exactly one is
/// known.
template <class Pose>
bool PoseFeed::predict(const GraphEdge<Pose>& edge, const Values& estimate, Values& fresh) const {
  const bool has_from = estimate.contains(edge.from);
  const bool has_to = estimate.contains(edge.to);
  if (has_from == has_to) return false;
  Pose pose = has_from ? estimate.at<Pose>(edge.from) * edge.measured
                       : estimate.at<Pose>(edge.to) * edge.measured.inverse();
  pose.normalize();
  fresh.insert(has_from ? edge.to : edge.from, pose);
  return true;
}

template <class Pose>
void PoseFeed::start_pose(const std::vector<GraphEdge<Pose>>& edges, std::size_t first,
                          const Values& estimate, Values& fresh) const {
  for (const bool odometry : {true, false}) {
    for (std::size_t f : factors_of_[next_]) {
      if (f < first || f >= first + edges.size()) continue;
      const GraphEdge<Pose>& edge = edges[f - first];
      if (is_odometry_(edge.from, edge.to) != odometry) continue;
      if (predict(edge, estimate, fresh)) return;
    }
  }
}

template <class Pose>
void PoseFeed::start_landmarks(const std::vector<GraphEdge<typename Pose::Point>>& edges,
                               std::size_t first, const Values& estimate, Values& fresh) const {
  for (std::size_t f : factors_of_[next_]) {
    if (f < first || f >= first + edges.size()) continue;
    const auto& edge = edges[f - first];
    if (estimate.contains(edge.to) || fresh.contains(edge.to)) continue;
    const Values& known = fresh.contains(edge.from) ? fresh : estimate;
    fresh.insert(edge.to, typename Pose::Point(known.at<Pose>(edge.from) * edge.measured));
  }
}

Key PoseFeed::pose() const {
  if (done()) {
    throw Error("no pose is left of the " + std::to_string(steps()) +
                " of the graph; ask whether the feed is done before each step");
  }
  return poses_[next_];
}

Delta PoseFeed::next(const Values& estimate) {
  pose();  // there is one
  Delta delta;
  if (next_ == 0) {
    const VariableType type = initial_.type(pose());
    delta.values.insert(pose(), type, initial_.data(pose()));
  }
  std::size_t first = 0;
  start_pose(graph_.poses2, first, estimate, delta.values);
  first += graph_.poses2.size();
  start_pose(graph_.poses3, first, estimate, delta.values);
  first += graph_.poses3.size();
  start_landmarks<SE2>(graph_.points2, first, estimate, delta.values);
  first += graph_.points2.size();
  start_landmarks<SE3>(graph_.points3, first, estimate, delta.values);
  for (std::size_t f : factors_of_[next_]) {
    if (hypotheses_[f] != nullptr) {
      delta.hybrid.push_back(hypotheses_[f]);
    } else {
      delta.continuous.push_back(factors_[f]);
    }
  }
  ++next_;
  return delta;
}

}  // namespace hybrid
