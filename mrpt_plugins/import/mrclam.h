// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>

#include "mrpt_plugins/import/detector_noise.h"
#include "mrpt_plugins/import/log_writer.h"
#include "mrpt_plugins/import/velocity_odometry.h"

namespace HYBRID_API hybrid {

/// UTIAS MR.CLAM (Leung et al. 2011): five robots in a room with barcoded cylinders.
struct MrclamOptions {
  /// Folder with Barcodes.dat, Landmark_Groundtruth.dat and RobotN_{Measurement,Odometry,
  /// Groundtruth}.dat; the latter two may be thinned, as RobotN_Odometry_changes.dat and
  /// RobotN_Groundtruth_10th.dat.
  std::string folder;
  int robot = 1;  ///< 1 to 5
  /// Keep sightings of other robots, robot N under the id -100 - N: none of a landmark.
  bool keep_robots = false;
  /// How far the camera is behind the velocity commands [s]; none: as the log itself tells, 0 where
  /// it does not (see estimate_sensor_delay).
  std::optional<double> delay;
  DetectorNoise detector{0.04, 0.04, 0.009, 0.02};
  OdometryWalk walk{0.06, 0.03, 0.06, 0.12, 1e-3};
};

/// Converts the measurements of one robot into a log with one step per time of measurement.
/// Landmark ids are subject numbers, odometry integrates the velocity commands, and the truth is
/// that of the motion capture.
ImportReport import_mrclam(const MrclamOptions& options, const std::string& output);

}  // namespace hybrid
