// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "libhybrid/association/prediction.h"
#include "libhybrid/geometry/se3.h"

namespace HYBRID_API hybrid {

/// A pose by odometry, from any origin.
struct OdometryPose {
  double time = 0;  ///< [s]
  SE3 pose;
};

/// The pose by odometry at a time: by steady motion between two poses, and rest before and after
/// all. There must be one.
SE3 pose_at(const std::vector<OdometryPose>& odometry, double time);

/// What a sensor saw at one time, (range, yaw) or (range, yaw, pitch) with their noise.
struct TimedSightings {
  double time = 0;  ///< [s], by the clock of the sensor
  SE3 T_robot_sensor;
  std::vector<MeasuredPoint> seen;
};

/// What a sensor saw at one time, and how the robot came there by odometry.
struct MovedSightings {
  TimedSightings sightings;
  /// Of what was seen, as long, or empty: sightings of two ids are of two things.
  std::vector<std::optional<std::int64_t>> ids = {};
  SE3 T_odometry_robot;  ///< from any origin, which is that of all frames of one chain
  /// Of the motion since the frame before, in the tangent (translation, rotation) of a right
  /// perturbation; zero in what a plane has not.
  SE3::Jacobian motion_covariance = SE3::Jacobian::Zero();
  int chain = 0;  ///< rises where the odometry between two frames is missing
};

/// How far a sensor is behind the odometry: what it saw at a time t of its clock is seen from where
/// the odometry was at t - seconds. Such a delay comes from clocks, from the time that a detector
/// takes, and from that between a command and the motion.
struct SensorDelay {
  double seconds = 0;
  double sigma = 0;  ///< standard deviation [s], infinite where nothing depends on the delay

  /// Whether the delay differs from none by more than three standard deviations.
  bool is_significant() const;
};

/// The delay, at most 1 s either way, at which successive sightings agree best with the motion of
/// the odometry between them, each with the nearest one of the frame before: robust (Cauchy) and
/// without identities. Only changes of velocity tell it. Its sigma is that of a jackknife over ten
/// parts of the log. Both in the order of time; motion is steady between two poses of `odometry`.
SensorDelay estimate_sensor_delay(const std::vector<OdometryPose>& odometry,
                                  const std::vector<TimedSightings>& sightings);

}  // namespace hybrid
