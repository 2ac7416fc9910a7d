// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <Eigen/Cholesky>
#include <algorithm>
#include <vector>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/sighted_point.h"
#include "libhybrid/pose_graph/graph_variables.h"
#include "libhybrid/pose_graph/pose_graph.h"
#include "libhybrid/pose_graph/sighting_edges.h"

namespace hybrid {
namespace {

/// Appends the edge if the factor is of type Factor.
template <class Factor, class T>
bool add_as(const ContinuousFactor& factor, std::vector<GraphEdge<T>>& edges) {
  const auto* known = dynamic_cast<const Factor*>(&factor);
  if (known == nullptr) return false;
  edges.push_back({known->keys()[0], known->keys()[1], known->measured(), noise_of(*known)});
  return true;
}

/// The same for a bearing-range measurement; one whose covariance as a position is singular (at
/// range zero) adds no edge.
template <class Pose>
bool add_bearing_range(const ContinuousFactor& factor,
                       std::vector<GraphEdge<typename Pose::Point>>& edges) {
  const auto* known = dynamic_cast<const BearingRange<Pose>*>(&factor);
  if (known == nullptr) return false;
  const auto seen = locate(Pose(), known->measured(), noise_of(*known), known->T_robot_sensor());
  if (Eigen::LLT<Eigen::MatrixXd>(seen.covariance).info() == Eigen::Success) {
    edges.push_back(
        {known->keys()[0], known->keys()[1], seen.mean, Noise::covariance(seen.covariance)});
  }
  return true;
}

template <class Pose>
bool add_edge(const ContinuousFactor& factor, std::vector<GraphEdge<Pose>>& poses,
              std::vector<GraphEdge<typename Pose::Point>>& points) {
  return add_relative_pose(factor, poses) || add_sighting<Pose>(factor, points);
}

}  // namespace

template <class Pose>
bool add_sighting(const ContinuousFactor& factor,
                  std::vector<GraphEdge<typename Pose::Point>>& edges) {
  return add_as<SightedPoint<Pose>>(factor, edges) || add_bearing_range<Pose>(factor, edges);
}
template bool add_sighting<SE2>(const ContinuousFactor& factor,
                                std::vector<GraphEdge<Eigen::Vector2d>>& edges);
template bool add_sighting<SE3>(const ContinuousFactor& factor,
                                std::vector<GraphEdge<Eigen::Vector3d>>& edges);

PoseGraph to_pose_graph(const HybridGraph& graph, const Estimate& estimate) {
  PoseGraph result;
  for (Key key : estimate.values.keys()) {
    const VariableType type = estimate.values.type(key);
    if (!is_pose_or_landmark(key, type)) continue;
    result.values.insert(key, type, estimate.values.data(key));
    if (key.letter() != key_letter::kPose) continue;
    if (result.fixed.empty()) result.fixed.push_back(key);
    result.fixed[0] = std::min(result.fixed[0], key);
  }
  const auto add = [&](const ContinuousFactor& factor) {
    for (Key key : factor.keys()) {
      if (!result.values.contains(key)) return;
    }
    add_edge<SE2>(factor, result.poses2, result.points2) ||
        add_edge<SE3>(factor, result.poses3, result.points3);
  };
  graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) { add(*factor); });
  graph.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    const Component component = factor->given(estimate.assignment);
    if (component.factor != nullptr && !component.weak) add(*component.factor);
  });
  erase_unseen_landmarks(result);
  return result;
}

}  // namespace hybrid
