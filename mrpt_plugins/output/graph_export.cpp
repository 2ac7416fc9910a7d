// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/graph_export.h"

#include <algorithm>

#include "libhybrid/core/error.h"
#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/calibrated_bearing_range.h"
#include "libhybrid/factors/calibrated_motion.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/pose_graph/graph_variables.h"
#include "mrpt_plugins/mapping/calibration.h"

namespace hybrid {
namespace {

/// Adds a sighting, with the estimated pose of the sensor where that is calibrated.
template <class Pose, class Edge>
bool add_sighting(const ContinuousFactor& factor, const Values& values, std::vector<Edge>& edges) {
  const auto add = [&](const auto& sighting, const Pose& T_robot_sensor) {
    const auto seen = locate(Pose(), sighting.measured(), noise_of(sighting), T_robot_sensor);
    edges.push_back(
        {factor.keys()[0], factor.keys()[1], seen.mean, Noise::covariance(seen.covariance)});
    return true;
  };
  if (const auto* sighting = dynamic_cast<const BearingRange<Pose>*>(&factor)) {
    return add(*sighting, sighting->T_robot_sensor());
  }
  const auto* sighting = dynamic_cast<const CalibratedBearingRange<Pose>*>(&factor);
  return sighting != nullptr && add(*sighting, values.at<Pose>(factor.keys()[2]));
}

/// Adds a motion corrected by the estimated calibration of the odometry.
template <class Factor, class Edge>
bool add_calibrated_motion(const ContinuousFactor& factor, const Values& values,
                           std::vector<Edge>& edges) {
  const auto* motion = dynamic_cast<const Factor*>(&factor);
  if (motion == nullptr) return false;
  edges.push_back({factor.keys()[0], factor.keys()[1], motion->motion(values), noise_of(*motion)});
  return true;
}

template <class Pose>
bool add_prior(const ContinuousFactor& factor, std::vector<Key>& fixed) {
  if (dynamic_cast<const Prior<Pose>*>(&factor) == nullptr) return false;
  fixed.push_back(factor.keys()[0]);
  return true;
}

bool has_vertex(Key key, const Values& values) {
  return is_pose_or_landmark(key, values.type(key));
}

/// Whether g2o has all variables of a factor but a calibration, which enters by its estimate.
bool has_vertices(const ContinuousFactor& factor, const Values& values) {
  return std::all_of(factor.keys().begin(), factor.keys().end(),
                     [&](Key key) { return is_calibration(key) || has_vertex(key, values); });
}

/// Whether the factor has a form in g2o. Throws Error where its noise has none there, as that of a
/// point seen at range 0.
bool add_known(const ContinuousFactor& factor, PoseGraph& g) {
  const Values& at = g.values;
  return add_relative_pose(factor, g.poses2) || add_relative_pose(factor, g.poses3) ||
         add_sighting<SE2>(factor, at, g.points2) || add_sighting<SE3>(factor, at, g.points3) ||
         add_calibrated_motion<CalibratedMotion2>(factor, at, g.poses2) ||
         add_calibrated_motion<CalibratedMotion3>(factor, at, g.poses3) ||
         add_prior<SE2>(factor, g.fixed) || add_prior<SE3>(factor, g.fixed);
}

void add(const ContinuousFactor& factor, ExportedGraph& out) {
  if (factor.keys().size() == 1 && is_calibration(factor.keys()[0])) return;
  bool known = false;
  try {
    known = has_vertices(factor, out.graph.values) && add_known(factor, out.graph);
  } catch (const Error&) {
    // left out, as is a factor without a form
  }
  const std::string name = factor.name();
  if (!known && std::find(out.left_out.begin(), out.left_out.end(), name) == out.left_out.end()) {
    out.left_out.push_back(name);
  }
}

}  // namespace

ExportedGraph export_graph(const HybridGraph& graph, const Estimate& estimate) {
  ExportedGraph out;
  out.graph.values = estimate.values;
  graph.continuous().for_each(
      [&](Handle, const ContinuousFactorPtr& factor) { add(*factor, out); });
  graph.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    const Component component = factor->given(estimate.assignment);
    if (component.factor != nullptr) add(*component.factor, out);
  });
  for (const Key key : out.graph.values.keys()) {
    if (!has_vertex(key, out.graph.values)) out.graph.values.erase(key);
  }
  erase_unseen_landmarks(out.graph);
  return out;
}

}  // namespace hybrid
