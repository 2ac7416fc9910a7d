// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Geometry>
#include <optional>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Tells where poses by odometry are missing while the robot moved on: it may have turned there,
/// and turned back. A robot that stood still may have said nothing.
class OdometryGap {
 public:
  /// What is told where they are.
  static constexpr const char* kMissing =
      "odometry missing: its poses are over ten times as far apart as usual, and the robot moved";

  /// Whether poses are missing before this one, the next one of the log, at a time [s].
  bool before(double time, const Eigen::Isometry3d& pose) {
    const double interval = last_ ? time - time_ : 0;
    const Eigen::Isometry3d step =
        last_ ? Eigen::Isometry3d(last_->inverse() * pose) : Eigen::Isometry3d::Identity();
    const double way = step.translation().norm(), turn = Eigen::AngleAxisd(step.linear()).angle();
    last_ = pose;
    time_ = time;
    if (!(interval > 0)) return false;
    const double usual = kLong * squares_ / sum_;
    const bool is_gap = count_ >= kLong && interval > usual &&
                        (way * sum_ > usual * way_ || turn * sum_ > usual * turn_);
    if (is_gap) return true;
    count_ += 1;
    sum_ += interval;
    squares_ += interval * interval;
    way_ += way;
    turn_ += turn;
    return false;
  }
  /// What comes next is in another frame.
  void start_anew() { last_.reset(); }

 private:
  /// Times as far apart as usual, which is known after as many.
  static constexpr double kLong = 10;

  std::optional<Eigen::Isometry3d> last_;
  double time_ = 0;
  // Of the steps so far. Where poses come in bursts, it is the time between these that counts.
  double count_ = 0, sum_ = 0, squares_ = 0, way_ = 0, turn_ = 0;
};

}  // namespace hybrid
