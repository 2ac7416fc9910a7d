// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/detections/detection.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/landmarks/landmark_events.h"
#include "libhybrid/landmarks/landmark_registry.h"

namespace HYBRID_API hybrid {

/// A keyframe whose detections are to become factors.
struct KeyframeView {
  Key pose;                       ///< its variable: SE2, or SE3 where `MapView::is_3d`
  Eigen::Isometry3d T_map_robot;  ///< its estimate before the detections are used
  const std::vector<DetectionFrame>& detections;
  /// Joint covariance (eq. 11b) of `pose`, before its detections are used, and of some variables of
  /// the map, in that order.
  std::function<Eigen::MatrixXd(const std::vector<Key>&)> joint_covariance = {};
  /// Covariance of J x, with x the same stacked: what is relative is known far better.
  std::function<Eigen::MatrixXd(const std::vector<Key>&, const Eigen::MatrixXd& J)> covariance_of =
      {};
};

/// What may be read of the map.
struct MapView {
  const Values& values;          ///< estimate before this keyframe
  const Assignment& assignment;  ///< of the discrete variables, before this keyframe
  const LandmarkRegistry& landmarks;
  bool is_3d = false;
  bool keeps_all = true;  ///< whether factors may still be removed by their handles
  bool explain = false;   ///< whether contributions are to say why, in `events`
  /// Whether a variable is in the graph and not marginalised out.
  std::function<bool(Key)> holds = {};
  /// Joint covariance (eq. 11b) of some variables of the map, in that order; that of a keyframe has
  /// its pose besides.
  std::function<Eigen::MatrixXd(const std::vector<Key>&)> joint_covariance = {};
  /// Covariance of J x, with x the same variables stacked.
  std::function<Eigen::MatrixXd(const std::vector<Key>&, const Eigen::MatrixXd& J)> covariance_of =
      {};
};

/// What is to be changed for one keyframe.
struct Contribution {
  Delta delta;                                 ///< new factors and variables
  std::vector<Landmark> landmarks;             ///< landmarks that `delta` introduces
  std::vector<std::int64_t> sighted;           ///< ids of landmarks, one entry per sighting
  std::vector<std::int64_t> unsighted;         ///< the reverse, where a sighting was not one
  std::vector<std::int64_t> forgotten;         ///< ids of landmarks that `delta` removes
  std::map<std::string, std::size_t> dropped;  ///< reason -> number of detections not used
  LandmarkEvents events;                       ///< why, where the map view asks for it
  bool settle = false;  ///< solve to convergence, as after a loop: one update may not come so far
  /// On trial: the map settles with it, and keeps it if the objective rises by no more than this.
  std::optional<double> allowed_rise = {};
  Values moved = {};  ///< on trial: where variables that are in the map are put first

  bool empty() const {
    return moved.empty() && delta.continuous.empty() && delta.discrete.empty() &&
           delta.hybrid.empty() && delta.remove.empty() && forgotten.empty();
  }
};

/// Enters the landmarks of a contribution into the registry. Throws Error where they contradict it;
/// roll the registry back then.
void enter(const Contribution& contribution, LandmarkRegistry& landmarks);

/// Tangent covariance of the motion from a pose of the map to that of the keyframe, perturbed from
/// the right; where the former pose has left the graph, that of the keyframe's pose.
Eigen::MatrixXd covariance_of_motion(const KeyframeView& frame, Key before, const MapView& map);
/// The same of a pose that is in the graph; `adjoint` is that of the motion back to it.
Eigen::MatrixXd covariance_of_motion(const KeyframeView& frame, Key before,
                                     const Eigen::MatrixXd& adjoint);

/// What became of a contribution.
struct Outcome {
  AddedHandles handles;         ///< of its factors, in the order of its delta
  double objective_before = 0;  ///< of the graph before the update it was part of
  double objective_after = 0;   ///< and after
  bool exact = true;            ///< false where local search stood in for exact discrete inference
};

}  // namespace hybrid
