// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/pose_graph/pose_graph.h"

#include <algorithm>
#include <deque>
#include <memory>
#include <optional>
#include <queue>
#include <string>
#include <tuple>
#include <type_traits>
#include <unordered_map>
#include <unordered_set>

#include "libhybrid/core/sort_unique.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/position.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/sighted_point.h"
#include "libhybrid/pose_graph/vertex_id.h"

namespace hybrid {
namespace {

/// The characters of a symbol of GTSAM, see vertex_index(); 0 for a plain number.
std::uint64_t characters_of(Key key) {
  const std::uint64_t index = key.index();
  return index <= static_cast<std::uint64_t>(kLargestPlainId) ? 0 : index >> 40U;
}

/// Keys of all poses, of vertices and edges, in order.
template <class Pose>
std::vector<Key> pose_keys(const PoseGraph& graph, const std::vector<GraphEdge<Pose>>& edges,
                           const std::vector<GraphEdge<typename Pose::Point>>& sightings) {
  std::vector<Key> keys;
  for (Key key : graph.values.keys()) {
    if (graph.values.type(key) == Variable<Pose>::type()) keys.push_back(key);
  }
  for (const auto& edge : edges) {
    keys.push_back(edge.from);
    keys.push_back(edge.to);
  }
  for (const auto& edge : sightings) keys.push_back(edge.from);
  sort_unique(keys);
  return keys;
}

/// Spanning trees over poses: along odometry, with other edges only where it ends, or of shortest
/// paths.
template <class Pose>
class Spanning {
 public:
  Spanning(const std::vector<Key>& keys, const std::vector<GraphEdge<Pose>>& edges,
           const OdometryEdges& is_odometry)
      : edges_(edges), is_odometry_(is_odometry), incident_(keys.size()) {
    for (std::size_t i = 0; i < keys.size(); ++i) ids_.emplace(keys[i], i);
    for (std::size_t e = 0; e < edges.size(); ++e) {
      incident_[ids_.at(edges[e].from)].push_back(e);
      incident_[ids_.at(edges[e].to)].push_back(e);
    }
  }

  /// Sets the poses that can be reached from the first one, by odometry if possible.
  void along_odometry(Key first, const Pose& start, Values& values) {
    std::deque<std::size_t> others;
    std::vector<Key> stack;
    const auto reach = [&](Key key, Pose pose) {
      pose.normalize();
      values.insert(key, pose);
      stack.push_back(key);
    };
    reach(first, start);
    while (true) {
      while (!stack.empty()) {
        const Key key = stack.back();
        stack.pop_back();
        for (std::size_t e : incident_[ids_.at(key)]) {
          const GraphEdge<Pose>& edge = edges_[e];
          if (!is_odometry_(edge.from, edge.to)) {
            others.push_back(e);
          } else {
            cross(edge, values, reach);
          }
        }
      }
      if (others.empty()) return;
      cross(edges_[others.front()], values, reach);
      others.pop_front();
    }
  }

  /// The same along shortest paths, by Dijkstra; ties go to the first edges.
  void along_shortest_paths(Key first, const Pose& start, Values& values) {
    struct Reached {
      double length;
      std::size_t edge;  // the edge to `key`
      Key key;
      bool operator<(const Reached& other) const {
        return std::tie(length, edge) > std::tie(other.length, other.edge);
      }
    };
    std::priority_queue<Reached> next;
    double length = 0.0;
    const auto reach = [&](Key key, Pose pose) {
      pose.normalize();
      values.insert(key, pose);
      for (const std::size_t e : incident_[ids_.at(key)]) {
        const Key other = edges_[e].from == key ? edges_[e].to : edges_[e].from;
        if (values.contains(other)) continue;
        next.push({length + rotation_variance(edges_[e].noise), e, other});
      }
    };
    reach(first, start);
    while (!next.empty()) {
      const Reached nearest = next.top();
      next.pop();
      length = nearest.length;
      cross(edges_[nearest.edge], values, reach);
    }
  }

 private:
  static double rotation_variance(const Noise& noise) {
    constexpr int kRotation = Pose::kDim - Pose::Point::RowsAtCompileTime;
    return noise.covariance().template bottomRightCorner<kRotation, kRotation>().trace();
  }

  /// Sets the end of an edge that has no value yet from the other end.
  template <class Reach>
  void cross(const GraphEdge<Pose>& edge, const Values& values, Reach& reach) {
    const bool has_from = values.contains(edge.from);
    const bool has_to = values.contains(edge.to);
    if (has_from && !has_to) reach(edge.to, values.at<Pose>(edge.from) * edge.measured);
    if (has_to && !has_from) reach(edge.from, values.at<Pose>(edge.to) * edge.measured.inverse());
  }

  const std::vector<GraphEdge<Pose>>& edges_;
  const OdometryEdges& is_odometry_;
  std::vector<std::vector<std::size_t>> incident_;
  std::unordered_map<Key, std::size_t> ids_;
};

void check_connected(const std::vector<Key>& keys, const Values& values) {
  std::string missing;
  int count = 0;
  for (Key key : keys) {
    if (values.contains(key)) continue;
    if (++count <= 10) missing += (count == 1 ? "" : ", ") + vertex_name(key.index());
  }
  if (count == 0) return;
  if (count > 10) missing += ", ... (" + std::to_string(count) + " in all)";
  throw Error("no edge connects vertex " + missing + " to vertex " + vertex_name(keys[0].index()));
}

/// Several parts have a common frame if each is measured in the map; else those behind the first
/// one are missing in the values.
template <class Pose>
void chain(const PoseGraph& graph, const std::vector<GraphEdge<Pose>>& edges,
           const std::vector<GraphEdge<typename Pose::Point>>& sightings, bool shortest_paths,
           Values& values) {
  using Point = typename Pose::Point;
  std::vector<Key> keys = pose_keys(graph, edges, sightings);
  const OdometryEdges is_odometry(graph);
  Spanning<Pose> spanning(keys, edges, is_odometry);
  std::unordered_set<Key> seen;
  std::optional<bool> is_framed;  // by what is measured in the map
  for (const Key first : keys) {
    if (seen.count(first) != 0) continue;
    const Pose start = graph.values.contains(first) ? graph.values.at<Pose>(first) : Pose();
    Values part;
    if (shortest_paths) {
      spanning.along_shortest_paths(first, start, part);
    } else {
      spanning.along_odometry(first, start, part);
    }
    for (const auto& sighting : sightings) {
      if (!part.contains(sighting.from) || part.contains(sighting.to)) continue;
      part.insert(sighting.to, Point(part.at<Pose>(sighting.from) * sighting.measured));
    }
    const bool in_map = move_to_map(graph, part);
    const bool has_frame = is_framed ? *is_framed && in_map : true;
    if (!is_framed) is_framed = in_map;
    for (const Key key : part.keys()) {
      seen.insert(key);
      if (has_frame && !values.contains(key)) values.insert(key, part.type(key), part.data(key));
    }
  }
  if (keys.empty()) return;
  for (Key key : graph.values.keys()) {
    if (graph.values.type(key) == Variable<Point>::type()) keys.push_back(key);
  }
  check_connected(keys, values);
}

template <class Pose, class Factor>
void add_factors(const std::vector<GraphEdge<Pose>>& edges, const Loss& loss,
                 std::vector<ContinuousFactorPtr>& factors) {
  for (const auto& edge : edges) {
    factors.push_back(
        std::make_shared<Factor>(edge.from, edge.to, edge.measured, edge.noise, loss));
  }
}

template <class Factor, class T>
void add_priors(const std::vector<GraphPrior<T>>& priors, const Loss& loss,
                std::vector<ContinuousFactorPtr>& factors) {
  for (const auto& prior : priors) {
    factors.push_back(std::make_shared<Factor>(prior.pose, prior.measured, prior.noise, loss));
  }
}

template <class Pose>
ContinuousFactorPtr position(const GraphPosition<typename Pose::Point>& p, const Loss& loss) {
  return std::make_shared<Position<Pose>>(p.pose, p.measured, p.noise, p.lever_arm, loss);
}

template <class T>
ContinuousFactorPtr anchor(Key key, const Values& values, double sigma) {
  return std::make_shared<Prior<T>>(key, values.at<T>(key),
                                    Noise::isotropic(Variable<T>::kDim, sigma));
}

ContinuousFactorPtr anchor(Key key, const Values& values, double sigma) {
  const VariableType type = values.type(key);
  if (type == Variable<SE2>::type()) return anchor<SE2>(key, values, sigma);
  if (type == Variable<SE3>::type()) return anchor<SE3>(key, values, sigma);
  if (type.dim == 2) return anchor<Eigen::Vector2d>(key, values, sigma);
  return anchor<Eigen::Vector3d>(key, values, sigma);
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

Values initialize_from_odometry(const PoseGraph& graph) {
  Values values;
  chain(graph, graph.poses2, graph.points2, false, values);
  chain(graph, graph.poses3, graph.points3, false, values);
  return values;
}

Values initialize_from_tree(const PoseGraph& graph) {
  Values values;
  chain(graph, graph.poses2, graph.points2, true, values);
  chain(graph, graph.poses3, graph.points3, true, values);
  return values;
}

std::vector<ContinuousFactorPtr> to_factors(const PoseGraph& graph, const Values& initial,
                                            const GraphFactorOptions& options) {
  std::vector<ContinuousFactorPtr> factors;
  factors.reserve(graph.edge_count() + graph.prior_count() +
                  std::max<std::size_t>(1, graph.fixed.size()));
  if (options.planar_logarithm) {
    add_factors<SE2, Between<SE2>>(graph.poses2, options.loss, factors);
  } else {
    add_factors<SE2, BetweenSE2>(graph.poses2, options.loss, factors);
  }
  add_factors<SE3, Between<SE3>>(graph.poses3, options.loss, factors);
  add_factors<Eigen::Vector2d, SightedPoint<SE2>>(graph.points2, options.loss, factors);
  add_factors<Eigen::Vector3d, SightedPoint<SE3>>(graph.points3, options.loss, factors);
  add_priors<Prior<SE2>>(graph.priors2, options.loss, factors);
  add_priors<Prior<SE3>>(graph.priors3, options.loss, factors);
  for (const auto& p : graph.positions2) factors.push_back(position<SE2>(p, options.loss));
  for (const auto& p : graph.positions3) factors.push_back(position<SE3>(p, options.loss));
  std::vector<Key> anchored = graph.fixed;
  if (anchored.empty() && graph.prior_count() == 0) {
    std::vector<Key> keys = pose_keys(graph, graph.poses2, graph.points2);
    if (keys.empty()) keys = pose_keys(graph, graph.poses3, graph.points3);
    if (!keys.empty()) anchored.push_back(keys[0]);
  }
  for (Key key : anchored) {
    const bool surveyed = !graph.fixed.empty() && graph.values.contains(key);
    factors.push_back(anchor(key, surveyed ? graph.values : initial, options.anchor_sigma));
  }
  return factors;
}

}  // namespace hybrid
