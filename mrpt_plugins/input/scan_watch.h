// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>

#include "libhybrid/scans/laser_scan.h"
#include "libhybrid/scans/scan_tracker.h"

namespace HYBRID_API hybrid {

/// Notices motion of which odometry says that there is none: wheels that slip, are lifted or are
/// not counted. While odometry rests, scans are matched with those since; where it moves, they are
/// not looked at.
class ScanWatch {
 public:
  /// A scan of a step that is a keyframe.
  void begin(LaserScan scan);
  /// Whether the robot, by a later scan, has moved as far as keyframes are apart; then that scan is
  /// one of a keyframe.
  bool has_moved(const LaserScan& scan);

 private:
  std::optional<LaserScan> keyframe_;
  std::optional<ScanTracker> tracker_;  // from the keyframe on, once odometry rests
  double time_ = 0;                     // of the last look [s], and where that was by odometry
  Eigen::Vector3d place_ = Eigen::Vector3d::Zero();
};

}  // namespace hybrid
