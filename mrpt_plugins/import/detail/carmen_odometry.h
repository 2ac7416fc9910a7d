// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/math/wrap2pi.h>
#include <mrpt/poses/CPose2D.h>

#include <algorithm>
#include <cstddef>
#include <deque>
#include <optional>

#include "mrpt_plugins/input/odometry_reset.h"

namespace hybrid {

/// The poses of ODOM lines, interpolated at the times of scans.
class CarmenOdometry {
 public:
  static constexpr std::size_t kTime = 7;  // the word of a line that is its time

  /// Has the last pose count in place of times, as where these are not of the clock of scans.
  void use_no_times() { has_times_ = false; }
  bool has_times() const { return has_times_; }

  /// Adds the next pose. One whose time goes back is left out.
  void add(double time, const mrpt::poses::CPose2D& pose) {
    constexpr std::size_t kMost = 1000;
    if (has_times_ && !poses_.empty() && time < poses_.back().time) return;
    poses_.push_back({time, pose, reset_.at({pose.x(), pose.y(), 0})});
    if (poses_.size() <= (has_times_ ? kMost : 1)) return;
    poses_.pop_front();
    has_begun_before_ = true;
  }

  /// Whether a line of that time or a later one has come.
  bool reaches(double time) const {
    return !has_times_ || (!poses_.empty() && poses_.back().time >= time);
  }

  /// The pose at a time; behind the last line that of it, before the first one none.
  std::optional<mrpt::poses::CPose2D> at(double time) const {
    if (poses_.empty()) return std::nullopt;
    if (!reaches(time) || !has_times_) return poses_.back().pose;
    const auto after =
        std::lower_bound(poses_.begin(), poses_.end(), time,
                         [](const Reading& reading, double t) { return reading.time < t; });
    if (after->time == time) return after->pose;
    if (after == poses_.begin()) {
      return has_begun_before_ ? std::optional(after->pose) : std::nullopt;
    }
    const Reading& before = *(after - 1);
    if (after->starts_anew) return before.pose;
    const double f = (time - before.time) / (after->time - before.time);
    const mrpt::poses::CPose2D step = after->pose - before.pose;
    return before.pose +
           mrpt::poses::CPose2D(f * step.x(), f * step.y(), f * mrpt::math::wrapToPi(step.phi()));
  }

 private:
  struct Reading {
    double time = 0;
    mrpt::poses::CPose2D pose;
    bool starts_anew = false;
  };

  bool has_times_ = true;
  bool has_begun_before_ = false;  // readings before the first of them were forgotten
  std::deque<Reading> poses_;
  OdometryReset reset_;
};

}  // namespace hybrid
