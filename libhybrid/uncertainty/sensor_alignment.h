// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "libhybrid/uncertainty/sensor_delay.h"

namespace HYBRID_API hybrid {

/// A unit of length other than the metre.
struct LengthUnit {
  double metres;
  const char* name;
};
inline constexpr LengthUnit kLengthUnits[] = {
    {0.3048, "feet"}, {0.0254, "inches"}, {0.01, "centimetres"}, {0.001, "millimetres"}};

/// How a sensor stands, and its clock, as far as the motion of the robot tells: what it saw agrees
/// best from one frame to another if its bearings have the other sign (or not), it is turned by
/// `yaw` about its vertical axis, and it is `delay` behind the odometry. Standard deviations are
/// those of a jackknife over 30 parts of the log, infinite where nothing depends on the number.
struct SensorAlignment {
  /// What its ranges are to be multiplied by where they fit the odometry far better in another
  /// unit, such as feet; the rest is then not measured.
  double length = 1;
  bool mirrored = false;     ///< bearings fit with the other sign
  double mirror_sigmas = 0;  ///< by how many standard deviations one sign fits better
  double yaw = 0, yaw_sigma = std::numeric_limits<double>::infinity();      ///< [rad]
  double delay = 0, delay_sigma = std::numeric_limits<double>::infinity();  ///< [s]
  /// Whether sign, yaw or delay differ from what the log states by more than three standard
  /// deviations, as does the agreement. The others are 0 above, with their standard deviations.
  bool is_significant = false;
  std::string unknown;  ///< what the log cannot tell, and why; empty if it tells all
};

/// Measures how a sensor stands by pairs of frames up to a second apart, each sighting with the
/// nearest one of the other frame: robust (Cauchy to search, Geman-McClure in the end) and without
/// identities.
/// Signs and yaws of all the circle are tried, and delays up to 1 s either way. Both in the order
/// of time; motion is steady between two poses of `odometry`.
SensorAlignment estimate_sensor_alignment(const std::vector<OdometryPose>& odometry,
                                          const std::vector<TimedSightings>& sightings);

}  // namespace hybrid
