// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "libhybrid/movers/point_sighting.h"

namespace HYBRID_API hybrid {

/// Where a thing that moves was at a time, and how fast, in the frame of the map; in the plane all
/// third coordinates are zero.
struct MoverState {
  double time = 0;                                     ///< [s]
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();  ///< [m/s]
  /// Of position and velocity, given the path of the robot.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
};

/// A thing that moves: no landmark, but a trajectory of its own.
struct Mover {
  std::int64_t id = 0;                      ///< number among the things that were followed
  double probability = 1;                   ///< that it moves
  std::vector<double> class_probabilities;  ///< empty where things have no classes
  int sightings = 0;
  std::vector<MoverState> states;  ///< in the order of time
};

/// The states at `times`, as far as these are between the first and the last of the sightings, and
/// all sightings taken into account (Kalman filter and Rauch-Tung-Striebel smoother), at the
/// highest of the speeds beforehand. Sightings and times are in the order of time; there is at
/// least one sighting.
std::vector<MoverState> smoothed_states(const std::vector<PointSighting>& sightings,
                                        const std::vector<double>& times, const MotionPrior& prior,
                                        bool is_3d);

}  // namespace hybrid
