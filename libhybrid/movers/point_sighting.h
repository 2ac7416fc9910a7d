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

/// What is known beforehand of things that move: they keep their velocity but for white noise of
/// acceleration.
struct MotionPrior {
  /// Standard deviations of each component of the velocity, one for each kind of motion, all kinds
  /// equally probable [m/s].
  std::vector<double> speeds = {1.5, 10};
  double acceleration = 2;  ///< by which each component changes within a second [m/s]
  /// Probability that a thing moves: one for each class, or one for all.
  std::vector<double> moving = {0.1};
};

}  // namespace hybrid
