// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <algorithm>
#include <optional>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Finds where the poses of odometry start anew, as after a restart of their driver: from far away
/// to within a step of where they began. A robot that drives back there comes step by step.
class OdometryReset {
 public:
  /// What is told where it does.
  static constexpr const char* kDropped =
      "odometry dropped: it starts anew, so that the motion there is not known";

  /// Whether odometry starts anew at this position [m], the next one of the log.
  bool at(const Eigen::Vector3d& position) {
    if (!first_) first_ = position;
    const double step = last_ ? (position - *last_).norm() : 0;
    last_ = position;
    const bool is_new =
        longest_ > 0 && step > kFar * longest_ && (position - *first_).norm() <= longest_;
    if (!is_new) longest_ = std::max(longest_, step);
    return is_new;
  }

 private:
  static constexpr double kFar = 5;  // of the longest step so far

  std::optional<Eigen::Vector3d> first_, last_;
  double longest_ = 0;  // step so far [m]
};

}  // namespace hybrid
