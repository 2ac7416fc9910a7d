// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/pose_graph/pose_feed.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <queue>
#include <string>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/pose_graph/vertex_id.h"

namespace hybrid {

using Neighbours = PoseFeed::Neighbours;

namespace {

bool is_pose(Key key) {
  return key.letter() == key_letter::kPose;
}

/// For each vertex, those that share a measurement with it which connects.
Neighbours connections(const std::vector<ContinuousFactorPtr>& factors,
                       const std::vector<bool>& connects) {
  Neighbours neighbours;
  for (std::size_t f = 0; f < factors.size(); ++f) {
    for (Key a : factors[f]->keys()) {
      std::vector<Key>& list = neighbours[a];
      for (Key b : factors[f]->keys()) {
        if (a != b && connects[f]) list.push_back(b);
      }
    }
  }
  return neighbours;
}

/// Appends the poses of a part from `first` on; the next one is always that of smallest id that a
/// measurement connects to earlier ones.
void append_part(Key first, const Neighbours& neighbours, std::unordered_set<Key>& seen,
                 std::vector<Key>& order) {
  const auto is_behind = [](Key a, Key b) { return b < a; };
  std::priority_queue<Key, std::vector<Key>, decltype(is_behind)> reachable(is_behind);
  seen.insert(first);
  reachable.push(first);
  while (!reachable.empty()) {
    const Key pose = reachable.top();
    reachable.pop();
    order.push_back(pose);
    for (Key other : neighbours.at(pose)) {
      if (is_pose(other) && seen.insert(other).second) reachable.push(other);
    }
  }
}

/// The poses measured in the map by what connects, or the one of smallest id if only landmarks are.
std::vector<Key> poses_in_map(const std::vector<ContinuousFactorPtr>& factors,
                              const std::vector<bool>& connects, std::size_t priors,
                              const Neighbours& neighbours) {
  std::vector<Key> poses;
  for (std::size_t f = priors; f < factors.size(); ++f) {
    if (connects[f] && is_pose(factors[f]->keys()[0])) poses.push_back(factors[f]->keys()[0]);
  }
  if (!poses.empty()) return poses;
  Key first{key_letter::kPose, ~std::uint64_t{0}};
  for (const auto& [key, list] : neighbours) {
    if (is_pose(key)) first = std::min(first, key);
  }
  return {first};
}

/// Whether positions measured in the map tell where it lies: two apart in the plane, three that are
/// on no line in space.
bool hold_map(const std::vector<Eigen::Vector3d>& positions, bool planar) {
  constexpr double kApart = 1e-3;  // [m]: nearer positions are of one place
  Eigen::Vector3d along = Eigen::Vector3d::Zero();
  double width = 0.0;
  for (const Eigen::Vector3d& position : positions) {
    const Eigen::Vector3d way = position - positions.front();
    if (way.norm() > along.norm()) along = way;
  }
  for (const Eigen::Vector3d& position : positions) {
    width = std::max(width, along.cross(position - positions.front()).norm());
  }
  return along.norm() > kApart && (planar || width > kApart * along.norm());
}

/// For each pose the positions that connect it to the map.
std::unordered_map<Key, std::vector<Eigen::Vector3d>> positions_of(
    const PoseGraph& graph, const std::vector<bool>& connects) {
  std::unordered_map<Key, std::vector<Eigen::Vector3d>> positions;
  std::size_t f = graph.edge_count() + graph.priors2.size() + graph.priors3.size();
  for (const auto& p : graph.positions2) {
    if (connects[f++]) positions[p.pose].emplace_back(p.measured.x(), p.measured.y(), 0.0);
  }
  for (const auto& p : graph.positions3) {
    if (connects[f++]) positions[p.pose].push_back(p.measured);
  }
  return positions;
}

void check_reached(const Neighbours& neighbours, const std::unordered_map<Key, std::size_t>& step,
                   Key first) {
  std::vector<Key> missing;
  for (const auto& [key, list] : neighbours) {
    if (step.count(key) == 0) missing.push_back(key);
  }
  if (missing.empty()) return;
  const Key key = *std::min_element(missing.begin(), missing.end());
  throw Error("no measurement connects vertex " + vertex_name(key.index()) + " to vertex " +
              vertex_name(first.index()) + " (" + std::to_string(missing.size()) +
              " such vertices in all)");
}

}  // namespace

PoseFeed::PoseFeed(const PoseGraph& graph, const Values& initial, const GraphFactorOptions& options,
                   const std::function<bool(std::size_t factor)>& connects)
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
  connects_.assign(factors_.size(), true);
  for (std::size_t f = 0; connects && f < factors_.size(); ++f) connects_[f] = connects(f);
  const Neighbours neighbours = connections(factors_, connects_);
  const std::vector<Key> in_map = poses_in_map(factors_, connects_, graph.edge_count(), neighbours);
  std::unordered_set<Key> seen;
  for (const Key first : in_map) {
    if (seen.count(first) != 0) continue;
    const std::size_t begin = poses_.size();
    append_part(first, neighbours, seen, poses_);
    split_into_steps(begin);
  }
  place_factors(neighbours, in_map.front());
}

/// The first step of a part has as many poses as it takes to tell where it lies.
void PoseFeed::split_into_steps(std::size_t begin) {
  const auto is_held = [&](Key pose) {
    for (std::size_t f = graph_.edge_count(); f < factors_.size(); ++f) {
      const ContinuousFactor& factor = *factors_[f];
      if (connects_[f] && factor.keys()[0] == pose && factor.rows() == factor.types()[0].dim) {
        return true;
      }
    }
    return false;
  };
  std::size_t first = 1;
  const auto positions = positions_of(graph_, connects_);
  if (positions.count(poses_[begin]) != 0 && !is_held(poses_[begin])) {
    std::vector<Eigen::Vector3d> known;
    for (first = 0; begin + first < poses_.size() && !hold_map(known, graph_.positions3.empty());) {
      const auto own = positions.find(poses_[begin + first++]);
      if (own != positions.end()) known.insert(known.end(), own->second.begin(), own->second.end());
    }
  }
  starts_.insert(poses_.begin() + std::ptrdiff_t(begin),
                 poses_.begin() + std::ptrdiff_t(begin + first));
  for (std::size_t k = begin + first; k <= poses_.size(); ++k) ends_.push_back(k);
}

/// Gives each factor to the step that has the last of its variables.
void PoseFeed::place_factors(const Neighbours& neighbours, Key first) {
  factors_of_.resize(ends_.size());
  std::unordered_map<Key, std::size_t> step;
  for (std::size_t k = 0, s = 0; k < poses_.size(); ++k) {
    if (k == ends_[s]) ++s;
    step.emplace(poses_[k], s);
  }
  const std::size_t sightings = graph_.poses2.size() + graph_.poses3.size();
  for (std::size_t f = sightings; f < graph_.edge_count(); ++f) {
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
      if (f < first || f >= first + edges.size() || !connects_[f]) continue;
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
    throw Error("no pose is left of the " + std::to_string(poses_.size()) +
                " of the graph; ask whether the feed is done before each step");
  }
  return poses_[ends_[next_] - 1];
}

Delta PoseFeed::next(const Values& estimate) {
  pose();  // there is one
  Delta delta;
  for (std::size_t k = added(); k < ends_[next_]; ++k) {
    if (starts_.count(poses_[k]) == 0) continue;
    delta.values.insert(poses_[k], initial_.type(poses_[k]), initial_.data(poses_[k]));
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
