// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Where a thing was seen in the map and, if that was measured, how it moved. In the plane the
/// third coordinate is zero.
struct PointSighting {
  double time = 0;                                       ///< [s]
  Eigen::Vector3d point = Eigen::Vector3d::Zero();       ///< [m]
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();  ///< of the point [m^2]
  bool has_velocity = false;                             ///< whether the next two are measured
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();    ///< [m/s]
  Eigen::Matrix3d velocity_covariance = Eigen::Matrix3d::Zero();  ///< [m^2/s^2]
};

/// A kind of motion: things keep their velocity but for white noise of acceleration.
struct MotionKind {
  double speed = 1.5;          ///< standard deviation of each component of the velocity [m/s]
  double acceleration = 0.75;  ///< by which each component changes within a second [m/s]
};

/// What is known beforehand of things that move.
struct MotionPrior {
  /// All equally probable. What walks, or creeps in a jam, changes its velocity by less than what
  /// drives: with the acceleration of the latter, a thing that starts and halts seems to stand.
  std::vector<MotionKind> kinds = {{1.5, 0.75}, {10, 2}};
  /// Probability that a thing moves: one for each class, or one for all.
  std::vector<double> moving = {0.1};
};

}  // namespace hybrid
