// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Where the robot was at a time [s], seen from another of its poses.
struct PoseBetween {
  double time = 0;
  Eigen::Isometry3d T_pose_robot = Eigen::Isometry3d::Identity();
};

/// The pose at a share of the way from one to another, by a turn about one axis.
Eigen::Isometry3d blend(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to, double part);

/// The readings of odometry between the steps of a log, or between keyframes.
class PosesBetween {
 public:
  /// Of more readings than this since the last step, every second one is left out, then every
  /// fourth and so on: at ten a second, more than 1.8 hours without a step.
  static constexpr std::size_t kMost = std::size_t{1} << 16;

  /// Takes where odometry says that the robot is. A reading whose time does not rise is left out.
  void add(double time, const Eigen::Isometry3d& T_odometry_robot);
  /// A step of this time, and where it is by the same odometry: the readings since the step before
  /// and up to it, seen from it. Without a step before there are none.
  std::vector<PoseBetween> to(double time, const Eigen::Isometry3d& T_odometry_step);
  /// Odometry does not tell how the robot came to a time: what was read up to it has no place.
  void lose(double time);
  /// The readings since the last step, seen from it.
  std::vector<PoseBetween> rest() const;

 private:
  std::deque<PoseBetween> readings_;   // in the frame of odometry, since the last step
  std::optional<PoseBetween> step_;    // the last one
  std::size_t read_ = 0, stride_ = 1;  // since the last step, and of those that are kept
};

}  // namespace hybrid
