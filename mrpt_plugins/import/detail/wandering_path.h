// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>

#include "mrpt_plugins/bridge/timed_pose.h"
#include "mrpt_plugins/import/detail/table_odometry.h"
#include "mrpt_plugins/input/odometry.h"

namespace hybrid {

/// The motion between two poses of an odometry that wanders, along the way between them: where they
/// are far apart in time, it wanders with the whole way, and turns that are not known move the end.
class WanderingPath {
 public:
  /// From a pose on; `translation` and `rotation` as for wandering_motion().
  WanderingPath(const TimedPose& from, bool is_3d, double translation, double rotation)
      : via_(from), is_3d_(is_3d), translation_(translation), rotation_(rotation) {}

  /// A pose on the way; times do not fall.
  void pass(const TimedPose& pose) {
    constexpr double kApart = 1;  // s, so that what readings tremble is no way
    if (pose.time - via_.time < kApart) return;
    so_far_ = to(pose.pose);
    via_ = pose;
  }

  /// The motion up to a pose.
  OdometryIncrement to(const mrpt::poses::CPose3D& pose) const {
    const OdometryIncrement last =
        wandering_motion(via_.pose, pose, is_3d_, translation_, rotation_);
    return so_far_ ? compose(*so_far_, last) : last;
  }

 private:
  TimedPose via_;
  std::optional<OdometryIncrement> so_far_;  // up to there
  bool is_3d_;
  double translation_, rotation_;
};

}  // namespace hybrid
