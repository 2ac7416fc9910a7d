// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <deque>

#include "libhybrid/factors/calibrated_motion.h"
#include "libhybrid/geometry/eigen.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/uncertain_motion.h"

namespace HYBRID_API hybrid {

/// The errors of odometry, measured by comparison with matches of scans. Those that all motions
/// share, scale and drift, are taken out. What is left is noise: standard deviations that grow with
/// distance and turn, times robust scales of the last keyframes.
class OdometryNoise {
 public:
  /// A motion by odometry without the errors that all share.
  SE2 corrected(const SE2& odometry) const { return calibrated(odometry, calibration()); }
  /// Covariance of a corrected motion of that length [m] along its path and that turn [rad].
  Eigen::Matrix3d covariance(double distance, double turn) const;

  /// Takes in a motion as odometry states it, the same as it was corrected step by step, and the
  /// same by a match. A part that the match does not tell better than odometry is not used.
  void compare(const SE2& stated, const SE2& corrected, double distance, double turn,
               const UncertainMotion& match);

  /// The most probable one by all comparisons, from what wheels on a floor may have. Where they
  /// lead to a scale that is not positive, which no wheels have, the scale is not measured and is
  /// one.
  OdometryCalibration2 calibration() const;

  double translation_scale() const { return translation_.scale; }
  double rotation_scale() const { return rotation_.scale; }

 private:
  struct Scale {
    double scale = 1.0;
    std::deque<double> errors;  // in standard deviations of scale 1
    void add(double error, double degrees_of_freedom);
  };

  /// Information about a part of the calibration, and that times the part.
  template <int kSize>
  struct Learnt {
    Eigen::Matrix<double, kSize, kSize> H = Eigen::Matrix<double, kSize, kSize>::Zero();
    Eigen::Matrix<double, kSize, 1> g = Eigen::Matrix<double, kSize, 1>::Zero();
  };

  Scale translation_, rotation_;
  Learnt<1> length_;  // scale of translation
  Learnt<2> angle_;   // scale of rotation, drift
};

}  // namespace hybrid
