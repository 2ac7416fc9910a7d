// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/uncertainty/detail/crossings.h"

#include <algorithm>
#include <map>
#include <utility>

#include "libhybrid/core/evenly_chosen.h"
#include "libhybrid/detections/sighting.h"
#include "libhybrid/initialization/direction_tracker.h"
#include "libhybrid/uncertainty/detail/look_table.h"

namespace hybrid {
namespace {

/// What a path errs by within a second, whatever made it: a position [m], an angle [rad].
constexpr double kWanderPosition = 0.01, kWanderAngle = 0.005;

/// Stretches begin before others have ended, so that there are enough places.
constexpr double kOverlap = 2;
constexpr double kMostStretches = 200;      // a budget
constexpr std::size_t kMostInstants = 100;  // of a stretch, evenly spread, a budget

SE3::Jacobian wander(double seconds, bool is_3d) {
  SE3::Jacobian out = SE3::Jacobian::Zero();
  out.diagonal().head<3>().setConstant(seconds * kWanderPosition * kWanderPosition);
  out.diagonal().tail<3>().setConstant(seconds * kWanderAngle * kWanderAngle);
  if (!is_3d) out.diagonal().segment<3>(2).setZero();  // z, roll, pitch
  return out;
}

/// The directions of a frame for a tracker to which the sensor is the robot.
DetectionFrame frame_of(const PlacedDetections& placed) {
  DetectionFrame out;
  out.time = placed.time;
  out.is_3d = placed.is_3d;
  out.has_range = false;
  for (const MeasuredPoint& seen : placed.seen) {
    Detection direction;
    direction.yaw = seen.z[1];
    direction.pitch = seen.z.size() > 2 ? seen.z[2] : 0;
    direction.covariance.topLeftCorner(seen.z.size(), seen.z.size()) = seen.covariance;
    out.detections.push_back(std::move(direction));
  }
  return out;
}

/// Of some frames, in order of time, those from a time on and before another.
std::vector<std::size_t> between(const std::vector<PlacedDetections>& frames,
                                 const std::vector<std::size_t>& some, double from, double to) {
  const auto is_before = [&](std::size_t i, double time) { return frames[i].time < time; };
  const auto first = std::lower_bound(some.begin(), some.end(), from, is_before);
  return {first, std::lower_bound(first, some.end(), to, is_before)};
}

/// What the directions of some frames of one sensor tell together.
PlacedDetections crossings_of(const std::vector<PlacedDetections>& frames,
                              const std::vector<std::size_t>& part, double memory) {
  DirectionTrackerOptions options;
  options.memory = memory;
  DirectionTracker tracker(options);
  for (std::size_t k = 0; k < part.size(); ++k) {
    const PlacedDetections& frame = frames[part[k]];
    if (k > 0) {
      const PlacedDetections& before = frames[part[k - 1]];
      tracker.move(before.T_map_sensor.inverse() * frame.T_map_sensor,
                   wander(frame.time - before.time, frame.is_3d));
    }
    tracker.take(frame_of(frame));
  }
  PlacedDetections out = frames[part.back()];
  out.time = (frames[part.front()].time + out.time) / 2;
  out.has_range = true;
  out.seen.clear();
  for (const DetectionFrame& known : tracker.release()) {
    for (const Detection& detection : known.detections) {
      if (detection.may_be_landmark()) out.seen.push_back(measured_point(detection, out.is_3d));
    }
  }
  return out;
}

}  // namespace

Crossings crossings(const std::vector<PlacedDetections>& frames, double stretch) {
  std::map<int, std::vector<std::size_t>> by_sensor;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i].has_range) by_sensor[frames[i].sensor].push_back(i);
  }
  Crossings out;
  for (const auto& [sensor, own] : by_sensor) {
    std::vector<std::size_t> crossing, looking;
    bool crosses = false;
    for (std::size_t k = 0; k < own.size(); ++k) {
      const bool is_new = k == 0 || frames[own[k]].time > frames[own[k - 1]].time;
      crosses = is_new ? !crosses : crosses;
      (crosses ? crossing : looking).push_back(own[k]);
    }
    const double begin = frames[own.front()].time, end = frames[own.back()].time;
    const double step = std::max(stretch / kOverlap, (end - begin) / kMostStretches);
    for (double time = begin; time <= end; time += step) {
      const std::vector<std::size_t> part =
          evenly_chosen(between(frames, crossing, time, time + stretch), kMostInstants);
      if (part.empty()) continue;
      out.places.push_back(crossings_of(frames, part, stretch));
      out.looks.push_back(between(frames, looking, time, time + stretch));
    }
  }
  return out;
}

}  // namespace hybrid
