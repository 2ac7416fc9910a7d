// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/import/detector_noise.h"
#include "mrpt_plugins/import/log_writer.h"
#include "mrpt_plugins/import/noisy_motion.h"

namespace HYBRID_API hybrid {

/// Objects in an office, seen by a carried RGB-D camera (Mu et al. 2016).
struct StataOptions {
  /// Folder with frames.txt (index seq T_world_camera) and detections.txt (frame class score x y z
  /// size box).
  std::string folder;
  MotionNoise noise{0.02, 0.01, 1};  ///< Added to the motions of the poses, which are the odometry.
  double period = 0.5;               ///< Between key-frames [s].
  /// Twice the scatter of sightings of an object, since their errors are correlated over some
  /// seconds.
  DetectorNoise detector{0.2, 0, 0.08, 0.06};
  double min_score = 0;  ///< Detections with a lower score are dropped.
  /// Radius within which sightings of a class, placed by the poses, belong to one object [m]. Its
  /// number is their true id, for evaluation. 0: no true ids.
  double oracle_radius = 0;
};

/// Converts the data set into a 3-D log with one step per key-frame. Its poses without the added
/// noise serve as ground truth, as the data set has none.
ImportReport import_stata(const StataOptions& options, const std::string& output);

}  // namespace hybrid
