// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <unordered_set>
#include <vector>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace hybrid {
namespace {

/// The motion that aligns the estimated with the measured positions best, in least squares; empty
/// if these are too few.
template <class Pose>
std::optional<Pose> align_positions(
    const std::vector<GraphPosition<typename Pose::Point>>& positions, const Values& values) {
  constexpr int n = Pose::Point::RowsAtCompileTime;
  if (positions.size() < std::size_t(n)) return std::nullopt;
  Eigen::Matrix<double, n, Eigen::Dynamic> estimated(n, positions.size()),
      measured(n, positions.size());
  for (std::size_t k = 0; k < positions.size(); ++k) {
    const auto column = static_cast<Eigen::Index>(k);
    estimated.col(column) = values.at<Pose>(positions[k].pose) * positions[k].lever_arm;
    measured.col(column) = positions[k].measured;
  }
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
  if (!poses.empty()) return from(poses[0].pose, poses[0].measured);
  if (const auto motion = align_positions<Pose>(positions, values)) return motion;
  if (graph.fixed.size() < 2) return std::nullopt;
  for (const Key key : graph.fixed) {
    if (key.letter() == key_letter::kPose && graph.values.contains(key)) {
      return from(key, graph.values.at<Pose>(key));
    }
  }
  return std::nullopt;
}

template <class Pose>
void move(const Pose& motion, Values& values) {
  for (const Key key : values.keys()) {
    if (values.type(key) == Variable<Pose>::type()) {
      Pose pose = motion * values.at<Pose>(key);
      pose.normalize();
      values.update(key, pose);
    } else {
      values.update(key, typename Pose::Point(motion * values.at<typename Pose::Point>(key)));
    }
  }
}

}  // namespace

void move_to_map(const PoseGraph& graph, Values& values) {
  if (values.empty()) return;
  bool planar = false;
  for (const Key key : values.keys()) planar = planar || values.type(key) == Variable<SE2>::type();
  if (planar) {
    const auto motion = motion_to_map<SE2>(graph, graph.priors2, graph.positions2, values);
    if (motion) move(*motion, values);
  } else {
    const auto motion = motion_to_map<SE3>(graph, graph.priors3, graph.positions3, values);
    if (motion) move(*motion, values);
  }
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
