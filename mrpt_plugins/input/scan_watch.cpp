// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/scan_watch.h"

#include <utility>

#include "libhybrid/geometry/isometry.h"
#include "mrpt_plugins/input/keyframe_policy.h"

namespace hybrid {
namespace {

/// Time from one look to the next [s]: in it a robot moves less than the matching of scans bridges.
constexpr double kBetweenLooks = 0.15;
/// Odometry rests where it is slower than this [m/s].
constexpr double kRest = 0.05;

}  // namespace

void ScanWatch::begin(LaserScan scan) {
  time_ = scan.time;
  place_.setZero();
  tracker_.reset();
  keyframe_ = std::move(scan);
}

bool ScanWatch::has_moved(const LaserScan& scan) {
  if (!keyframe_ || scan.time < time_ + kBetweenLooks) return false;
  if (scan.T_robot_sensor.matrix() != keyframe_->T_robot_sensor.matrix()) return false;
  const Eigen::Vector3d place = scan.T_keyframe_robot.translation();
  const bool rests = (place - place_).norm() < kRest * (scan.time - time_);
  time_ = scan.time;
  place_ = place;
  if (!rests) {
    tracker_.reset();
    return false;
  }
  std::optional<SE2> motion;
  if (!tracker_) {
    ScanTrackerOptions options;
    options.keyframe_distance = kScanKeyframes.min_distance;
    options.keyframe_turn = kScanKeyframes.min_angle;
    tracker_.emplace(options).track(scan_points(*keyframe_), std::nullopt);
    motion = to_se2(scan.T_keyframe_robot);
  }
  if (!tracker_->track(scan_points(scan), motion).is_keyframe) return false;
  keyframe_ = scan;
  place_.setZero();
  return true;
}

}  // namespace hybrid
