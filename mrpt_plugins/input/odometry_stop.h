// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Tells where the odometry stands still for a while, and both stops and goes on faster than a
/// robot brakes and starts: as that of a driver that has died, while the robot drives on.
class OdometryStop {
 public:
  /// Whether such a stop was right before this step of the log, at a time [s], after a way [m] and
  /// a turn [rad] by odometry.
  bool before(double time, double way, double turn) {
    const double interval = time - time_;
    if (!(interval > 0)) {  // the first step, or one more at its time
      time_ = std::isnan(time_) ? time : time_;
      return false;
    }
    const double speed = way / interval, two_steps = interval + interval_;
    const bool stands = way < kNothing && std::abs(turn) < kNothing;
    // The steps at both ends are part of the motion, part of the stop.
    const bool is_sudden = std::max(speed, speed_) > kBrakes * two_steps;
    const bool ends = ended_ && !stands && is_sudden;
    ended_ = !stands && steps_ > kSteps && time_ - since_ > kLasts && stopped_suddenly_;
    if (stands && steps_++ == 0) {
      since_ = time_;
      stopped_suddenly_ = std::max(speed_, speed_before_) > kBrakes * two_steps;
    }
    if (!stands) steps_ = 0;
    speed_before_ = speed_;
    speed_ = speed;
    interval_ = interval;
    time_ = time;
    return ends;
  }

 private:
  static constexpr double kBrakes = 5;  // [m/s^2]: wheels slip
  static constexpr double kLasts = 1;   // [s]
  static constexpr std::size_t kSteps = 10;
  static constexpr double kNothing = 1e-6;  // [m], [rad]

  // Of the step before, and the speed of that before it.
  double time_ = std::nan(""), interval_ = 0, speed_ = 0, speed_before_ = 0;
  std::size_t steps_ = 0;  // it stands since
  double since_ = 0;       // [s]
  bool stopped_suddenly_ = false;
  bool ended_ = false;  // such a stop, with the step before
};

}  // namespace hybrid
