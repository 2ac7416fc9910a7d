// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Counts where the odometry stands still for a while, and both stops and goes on faster than a
/// robot brakes and starts: as that of a driver that has died, while the robot drives on.
class OdometryStop {
 public:
  /// The next motion by odometry, up to a time [s].
  void take(double time, const Eigen::Isometry3d& motion) {
    const double interval = time - time_;
    if (!(interval > 0)) {  // the first one, or one more at its time
      time_ = std::isnan(time_) ? time : time_;
      return;
    }
    const double way = motion.translation().norm();
    const double speed = way / interval, two_steps = interval + interval_;
    const bool stands = way < kNothing && Eigen::AngleAxisd(motion.linear()).angle() < kNothing;
    // The motions at both ends may be part of the drive, part of the stop.
    if (ended_ && !stands && std::max(speed, speed_) > kBrakes * two_steps) ++count_;
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
  }
  std::size_t count() const { return count_; }

 private:
  static constexpr double kBrakes = 5;  // [m/s^2]: wheels slip
  static constexpr double kLasts = 1;   // [s]
  static constexpr std::size_t kSteps = 10;
  static constexpr double kNothing = 1e-6;  // [m], [rad]

  // Of the motion before, and the speed of that before it.
  double time_ = std::nan(""), interval_ = 0, speed_ = 0, speed_before_ = 0;
  std::size_t steps_ = 0;  // it stands since
  double since_ = 0;       // [s]
  bool stopped_suddenly_ = false;
  bool ended_ = false;  // such a stop, with the motion before
  std::size_t count_ = 0;
};

}  // namespace hybrid
