// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/plugins/bearing_range_association.h"

#include <algorithm>

#include "libhybrid/core/spatial_values.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/geometry/isometry.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/mapping/register_plugin.h"
#include "mrpt_plugins/plugins/read_landmark_options.h"

HYBRID_REGISTER_PLUGIN(BearingRangeAssociation, hybrid)

namespace hybrid {

void BearingRangeAssociation::configure(IniSection section) {
  sensors_ = read_sensors(section);
  const ClassModel classes = read_class_model(section);
  association_ = LandmarkAssociation(read_association_options(section), classes, sensors_);
  DirectionTrackerOptions o;
  section.read("least_depth", o.least_depth,
               "of a thing that is seen by direction alone, at first sight [m]", kPositiveLength);
  section.read("range_sigma", o.range_sigma,
               "its range is known where its sigma is at most this share of it", {0.01, 0.5});
  section.read("memory", o.memory, "it is given up once it was not seen for so long [s]", {0, 1e4});
  directions_ = DirectionTracker(o);
  section.read("every", every_,
               "way after which the ranges that directions tell by then are used [m]",
               kPositiveLength);
}

Contribution BearingRangeAssociation::observe(const Frame& frame, const MapView& map) {
  const bool all_have_ranges =
      std::all_of(frame.detections.begin(), frame.detections.end(),
                  [](const DetectionFrame& seen) { return seen.has_range; });
  if (!last_pose_ && all_have_ranges) return association_.observe(frame.view(), map);
  std::vector<DetectionFrame> with_range, directions;
  std::map<std::string, std::size_t> dropped;
  for (const DetectionFrame& seen : frame.detections) {
    if (seen.has_range || !is_wanted(seen.sensor_label, sensors_)) {
      with_range.push_back(seen);
      continue;
    }
    const std::string reason = misfit_of_bearing(seen, map.is_3d);
    if (reason.empty()) {
      directions.push_back(seen);
    } else if (!seen.detections.empty()) {
      dropped["detection dropped: " + reason] += seen.detections.size();
    }
  }
  const bool only_directions = with_range.empty() && (last_pose_ || !directions.empty());
  if (last_pose_ || !directions.empty()) follow(frame, map);
  for (const DetectionFrame& seen : directions) directions_.take(seen);
  if (way_ >= every_) {
    way_ = 0;
    for (DetectionFrame& seen : directions_.release()) with_range.push_back(std::move(seen));
  }
  // What a keyframe without a detection does not show was not missed: its range is not known yet.
  asked_ = !only_directions || !with_range.empty();
  Contribution out;
  if (asked_) {
    const KeyframeView view = frame.view();
    out = association_.observe(
        {view.pose, view.T_map_robot, with_range, view.joint_covariance, view.covariance_of}, map);
  }
  for (const auto& [reason, count] : dropped) out.dropped[reason] += count;
  return out;
}

/// Tells the tracker of directions how the robot has moved.
void BearingRangeAssociation::follow(const Frame& frame, const MapView& map) {
  const KeyframeView view = frame.view();
  if (last_pose_ && *last_pose_ != view.pose) {
    const bool known = map.values.contains(*last_pose_);
    const Eigen::Isometry3d motion =
        between(known ? isometry_at(map.values, *last_pose_) : T_map_last_, view.T_map_robot);
    const Eigen::MatrixXd covariance = covariance_of_motion(view, *last_pose_, map);
    const SE3::Jacobian in_space = map.is_3d ? SE3::Jacobian(covariance) : planar_to_6d(covariance);
    directions_.move(motion, in_space);
    way_ += motion.translation().norm();
  }
  last_pose_ = view.pose;
  T_map_last_ = view.T_map_robot;
}

std::map<std::string, double> BearingRangeAssociation::statistics() const {
  std::map<std::string, double> out = association_.statistics();
  if (directions_.taken() == 0) return out;
  out["directions"] = static_cast<double>(directions_.taken());
  out["directions_with_range"] = static_cast<double>(directions_.released());
  return out;
}

}  // namespace hybrid
