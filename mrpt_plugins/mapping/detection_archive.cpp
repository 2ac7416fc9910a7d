// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/detection_archive.h"

#include <map>
#include <string>
#include <utility>

#include "libhybrid/detections/sighting.h"
#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

/// The angles of a detection; what it says of the range means nothing.
MeasuredPoint measured_direction(Detection detection, bool is_3d) {
  detection.range = 0;
  detection.covariance.row(0).setZero();
  detection.covariance.col(0).setZero();
  return measured_point(detection, is_3d);
}

}  // namespace

void DetectionArchive::add(std::size_t number, const Keyframe& keyframe) {
  for (const DetectionFrame& frame : keyframe.detections) {
    frames_.push_back({number, frame});
    count_ += frame.detections.size();
    if (frame.time == 0) frames_.back().detections.time = keyframe.time;
  }
  if (count_ > budget_) thin_out();
}

void DetectionArchive::thin_out() {
  std::size_t kept = 0;
  count_ = 0;
  for (std::size_t i = 0; i < frames_.size(); i += 2) {
    count_ += frames_[i].detections.detections.size();
    if (i != kept) frames_[kept] = std::move(frames_[i]);
    ++kept;
  }
  frames_.resize(kept);
}

std::vector<PlacedDetections> DetectionArchive::placed(const Mapper& mapper,
                                                       const Trajectory& keyframes) const {
  std::map<std::pair<std::size_t, std::string>, int> sensors;
  std::vector<PlacedDetections> out;
  for (const auto& [keyframe, frame] : frames_) {
    const bool is_3d = mapper.is_3d();
    if (!(frame.has_range ? misfit(frame, is_3d) : misfit_of_bearing(frame, is_3d)).empty()) {
      continue;
    }
    const std::size_t robot = mapper.robot_of(keyframe);
    const int next = static_cast<int>(sensors.size());
    PlacedDetections placed;
    placed.time = frame.time;
    placed.robot = static_cast<int>(robot);
    placed.sensor = sensors.try_emplace({robot, frame.sensor_label}, next).first->second;
    placed.is_3d = is_3d;
    placed.has_range = frame.has_range;
    placed.T_map_sensor =
        to_isometry(keyframes[keyframe].pose) *
        mapper.calibrated_sensor(robot, frame.sensor_label).value_or(frame.T_robot_sensor);
    for (const Detection& detection : frame.detections) {
      if (!detection.may_be_landmark()) continue;
      placed.seen.push_back(frame.has_range ? measured_point(detection, is_3d)
                                            : measured_direction(detection, is_3d));
    }
    out.push_back(std::move(placed));
  }
  return out;
}

}  // namespace hybrid
