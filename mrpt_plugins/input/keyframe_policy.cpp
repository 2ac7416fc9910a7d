// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/keyframe_policy.h"

#include <algorithm>
#include <cmath>

namespace hybrid {
namespace {

double rotation_angle(const mrpt::poses::CPose3D& T) {
  const double trace = T.getRotationMatrix().asEigen().trace();
  return std::acos(std::clamp((trace - 1) / 2, -1.0, 1.0));
}

}  // namespace

bool KeyframePolicy::is_keyframe(const LogStep& step) {
  if (accepted_) {
    between_ = step.odometry;
  } else if (between_ && step.odometry) {
    between_ = compose(*between_, *step.odometry);
  } else {
    between_.reset();
  }
  const auto reached = [](double value, double threshold) {
    return threshold > 0 && value >= threshold;
  };
  const bool all_off =
      options_.min_distance <= 0 && options_.min_angle <= 0 && options_.min_time <= 0;
  accepted_ = !started_ || all_off || !between_ ||
              reached(between_->mean.norm(), options_.min_distance) ||
              reached(rotation_angle(between_->mean), options_.min_angle) ||
              reached(step.time - last_time_, options_.min_time);
  started_ = true;
  if (accepted_) last_time_ = step.time;
  return accepted_;
}

void KeyframePolicy::accept(double time) {
  accepted_ = true;
  last_time_ = time;
}

}  // namespace hybrid
