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
  MotionNoise noise{0.02, 0.01, 1};  ///< Given to the odometry, which is the motion of the poses.
  double period = 0.5;               ///< Between key-frames [s].
  /// Twice what sightings of an object scatter by, since their errors last for some seconds.
  DetectorNoise detector{0.2, 0, 0.08, 0.06};
  double min_score = 0;  ///< Detections with less are dropped.
  /// Radius in which sightings of a class, put into place by the poses, are taken for one object
  /// [m]; their number becomes their true id, for comparison. 0: no true ids.
  double oracle_radius = 0;
};

/// Converts the data set into a log in space with a step for each key-frame. There is no truth: the
/// poses that the noise is added to stand for it.
ImportReport import_stata(const StataOptions& options, const std::string& output);

}  // namespace hybrid
