// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>

#include "mrpt_plugins/input/rawlog_reader.h"

namespace HYBRID_API hybrid {

/// A frame becomes a keyframe once the motion since the last one reaches any threshold that is set;
/// 0 switches a threshold off, and with all off every frame is a keyframe.
struct KeyframeOptions {
  double min_distance = 0;  ///< Straight line between keyframes [m].
  double min_angle = 0;     ///< Rotation between keyframes [rad].
  double min_time = 0;      ///< [s].
};

/// Chooses keyframes and adds up the odometry between them.
class KeyframePolicy {
 public:
  explicit KeyframePolicy(const KeyframeOptions& options = {}) : options_(options) {}

  /// Takes each step in turn and says whether it is a keyframe; the first step is.
  bool is_keyframe(const LogStep& step);

  /// Motion from the keyframe before to the one just accepted, covariances added up. Nothing at the
  /// first keyframe unless its step had odometry, and wherever a step in between lacked odometry.
  const std::optional<OdometryIncrement>& odometry() const { return between_; }

 private:
  KeyframeOptions options_;
  bool started_ = false;
  bool accepted_ = true;  // the sum starts anew at the next step
  double last_time_ = 0;
  std::optional<OdometryIncrement> between_;
};

}  // namespace hybrid
