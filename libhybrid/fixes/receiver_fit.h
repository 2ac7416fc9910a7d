// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/fixes/fix_model.h"
#include "libhybrid/geometry/se2.h"

namespace HYBRID_API hybrid {

/// A fix and the planar motion by odometry since the one before.
struct MovedFix {
  double time = 0;                                     ///< [s]
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< east, north of a datum [m]
  double sigma = 0;                                    ///< as stated [m]; 0: not stated
  Eigen::Vector2d antenna = Eigen::Vector2d::Zero();   ///< on the robot [m]
  SE2 motion;
  /// Of the motion, as stated, in the tangent of a right perturbation: m, m, rad.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  /// Of the robot at the time of the fix, along its axes [m/s].
  Eigen::Vector2d velocity = Eigen::Vector2d::Zero();
  bool begins = false;  ///< the motion is not known: a new stretch
};

/// What fixes and odometry tell of each other's noise.
struct ReceiverFit {
  /// `good_sigma` is that of fixes which do not state one.
  FixModel model;
  double sigma_factor = 1;               ///< of the sigmas that the receiver states
  double translation = 1, rotation = 1;  ///< factors of the standard deviations of odometry
  double delay = 0;                      ///< by which stamps of fixes are late [s]
  bool is_known = false;  ///< else too few fixes, or no direction of north, was found
};

/// The parameters of largest posterior probability, by a filter of the switching system along
/// odometry alone: pose and lasting error, a Gaussian for good and one for biased errors. What each
/// is known for before is its value in `prior`, or 1 for factors, within a factor of e (one
/// standard deviation), of 1.6 for size and time of errors that last, which odometry that drifts
/// resembles; the delay is 0 +- 0.3 s, and 0 where fixes are not sure of another. Of long logs, a
/// few stretches of fixes count.
ReceiverFit fit_receiver(const std::vector<MovedFix>& fixes, const FixModel& prior);

}  // namespace hybrid
