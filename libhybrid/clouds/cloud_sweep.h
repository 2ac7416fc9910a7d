// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <vector>

#include "libhybrid/geometry/se3.h"

namespace HYBRID_API hybrid {

/// No point of a sweep is farther from its stamp [s].
inline constexpr double kLongestSweep = 1;

/// Moves the points of a sweep to where they would have been seen at its stamp, by a robot whose
/// velocity is constant: at the time t after the stamp it is at SE3::exp(t `velocity`), in its
/// frame at the stamp.
///
/// `points` are in the frame that the robot had when it saw each [m], `times` when that was after
/// the stamp [s], negative before, as many as there are points or none. `velocity` is in the frame
/// of the robot [m/s, rad/s]. Points stay where they are whose time is not finite or farther than
/// kLongestSweep from the stamp.
std::vector<Eigen::Vector3f> deskewed(std::vector<Eigen::Vector3f> points,
                                      const std::vector<float>& times,
                                      const SE3::Tangent& velocity);

/// The velocity of a robot while it sweeps, by its motion from cloud to cloud.
class SweepVelocity {
 public:
  /// For a cloud at `time` [s]: by `odometry`, the motion since the cloud before, or else by the
  /// last match. Zero where nothing is known, and where clouds are more than two seconds apart,
  /// over which no velocity is constant.
  SE3::Tangent at(double time, const std::optional<SE3>& odometry) const;
  /// A cloud at `time` [s], and its motion since the one before by a match, where it has one.
  void add(double time, const std::optional<SE3>& matched);

 private:
  std::optional<SE3::Tangent> mean(double time, const SE3& motion) const;

  std::optional<double> last_;  // time of the last cloud
  std::optional<SE3::Tangent> matched_;
};

}  // namespace hybrid
