// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <unordered_set>
#include <vector>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/core/move_variable.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace hybrid {
namespace {

/// The motion that aligns the estimated with the measured positions best, in least squares; empty
/// if these are too few.
template <class Pose>
std::optional<Pose> align_positions(
    const std::vector<GraphPosition<typename Pose::Point>>& positions, const Values& values) {
  constexpr int n = Pose::Point::RowsAtCompileTime;
  Eigen::Matrix<double, n, Eigen::Dynamic> estimated(n, positions.size()),
      measured(n, positions.size());
  Eigen::Index count = 0;
  for (const auto& position : positions) {
    if (!values.contains(position.pose)) continue;
    estimated.col(count) = values.at<Pose>(position.pose) * position.lever_arm;
    measured.col(count++) = position.measured;
  }
  if (count < n) return std::nullopt;
  estimated.conservativeResize(n, count);
  measured.conservativeResize(n, count);
  const Eigen::Matrix<double, n + 1, n + 1> T = Eigen::umeyama(estimated, measured, false);
  const Eigen::Matrix<double, n, n> R = T.template topLeftCorner<n, n>();
  const Eigen::Matrix<double, n, 1> t = T.template topRightCorner<n, 1>();
  if constexpr (n == 2) {
    return Pose(t.x(), t.y(), std::atan2(R(1, 0), R(0, 0)));
  } else {
    return Pose(t, Eigen::Quaterniond(R));
  }
}

template <class Pose>
std::optional<Pose> motion_to_map(const PoseGraph& graph,
                                  const std::vector<GraphPrior<Pose>>& poses,
                                  const std::vector<GraphPosition<typename Pose::Point>>& positions,
                                  const Values& values) {
  const auto from = [&](Key key, const Pose& pose) {
    return Pose(pose * values.at<Pose>(key).inverse());
  };
  for (const Key key : graph.fixed) {
    if (key.letter() == key_letter::kPose && graph.values.contains(key) && values.contains(key)) {
      return from(key, graph.values.at<Pose>(key));
    }
  }
  for (const GraphPrior<Pose>& prior : poses) {
    if (values.contains(prior.pose)) return from(prior.pose, prior.measured);
  }
  return align_positions<Pose>(positions, values);
}

template <class Pose>
void move(const Pose& motion, Values& values) {
  for (const Key key : values.keys()) move_variable(motion, key, values);
}

}  // namespace

bool move_to_map(const PoseGraph& graph, Values& values) {
  bool planar = false;
  for (const Key key : values.keys()) planar = planar || values.type(key) == Variable<SE2>::type();
  if (planar) {
    const auto motion = motion_to_map<SE2>(graph, graph.priors2, graph.positions2, values);
    if (motion) move(*motion, values);
    return motion.has_value();
  }
  const auto motion = motion_to_map<SE3>(graph, graph.priors3, graph.positions3, values);
  if (motion) move(*motion, values);
  return motion.has_value();
}

std::size_t erase_unseen_landmarks(PoseGraph& graph) {
  std::unordered_set<Key> used(graph.fixed.begin(), graph.fixed.end());
  for (const auto& edge : graph.points2) used.insert(edge.to);
  for (const auto& edge : graph.points3) used.insert(edge.to);
  std::size_t erased = 0;
  for (const Key key : graph.values.keys()) {
    if (key.letter() != key_letter::kLandmark || used.count(key) != 0) continue;
    graph.values.erase(key);
    ++erased;
  }
  return erased;
}

}  // namespace hybrid
