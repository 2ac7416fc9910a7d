// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>

#include "mrpt_plugins/input/rawlog_reader.h"

namespace HYBRID_API hybrid {

/// A frame becomes a keyframe once the motion since the last one reaches a threshold, or if its
/// odometry is missing. 0 switches a threshold off; if all are off, every frame is a keyframe.
struct KeyframeOptions {
  double min_distance = 0;  ///< Straight line between keyframes [m].
  double min_angle = 0;     ///< Rotation between keyframes [rad].
  double min_time = 0;      ///< [s].
};

/// For laser scans, of which those between keyframes are used as well: so near that a scan sees
/// most of what the one at the keyframe before saw.
inline constexpr KeyframeOptions kScanKeyframes{0.5, 0.35, 0};

/// Selects keyframes and accumulates the odometry between them.
class KeyframePolicy {
 public:
  explicit KeyframePolicy(const KeyframeOptions& options = {}) : options_(options) {}

  /// Whether a step is a keyframe, as the first step is. Call it once for each step in order.
  bool is_keyframe(const LogStep& step);
  /// Makes the step that was asked about last, at this time [s], a keyframe in any case.
  void accept(double time);

  /// Motion from the last keyframe to the one just accepted, covariances propagated. Nothing if a
  /// step in between lacked odometry; at the first keyframe, only the odometry of its step, if any.
  const std::optional<OdometryIncrement>& odometry() const { return between_; }

 private:
  KeyframeOptions options_;
  bool started_ = false;
  bool accepted_ = true;  // the next step starts a new sum
  double last_time_ = 0;
  std::optional<OdometryIncrement> between_;
};

}  // namespace hybrid
