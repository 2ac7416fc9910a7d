// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/import/detector_noise.h"
#include "mrpt_plugins/import/log_writer.h"
#include "mrpt_plugins/import/velocity_odometry.h"

namespace HYBRID_API hybrid {

/// Victoria Park (Guivant and Nebot): a car with a laser among trees.
struct VictoriaParkOptions {
  /// Folder with odometry.txt (t speed steering), scan_times.txt (t), tree_detections.txt (t range
  /// bearing diameter; bearing pi/2 is straight ahead), gps.txt (t x y), and for the reference
  /// association victoria_park_known_assoc_gtsam.txt.
  std::string folder;
  /// Whether detections get the landmark ids of the reference association.
  bool reference = true;
  /// The steering angle is steering_scale times the reading plus steering_offset [rad]: the values
  /// that fit the path among the trees of the reference association. 1 and 0: as read.
  double steering_scale = 1.037, steering_offset = 0.0046;
  DetectorNoise detector{0.09, 0.005, 0.011, 0};
  OdometryWalk walk{0.05, 0.02, 0.008, 0, 1e-4};
  /// Which runs of satellite fixes are in the log, a run being one without a pause of more than a
  /// second: all, even, odd or none; the first is run 0. With even and odd, the others are written
  /// beside the log.
  std::string fixes = "all";
};

/// Converts the data set into a log with one step per scan. The robot frame is at the middle of the
/// rear axle; its motion follows the standard car model from the speed of the left rear wheel and
/// the steering angle. Satellite fixes, all of them, are in the frame of the first scan that is not
/// before them, with their own time stamps; their frame is local, and put about a place in the park
/// that is arbitrary. Beside the log they are written as true positions, without those farther from
/// the last good one than the car drove.
ImportReport import_victoria_park(const VictoriaParkOptions& options, const std::string& output);

}  // namespace hybrid
