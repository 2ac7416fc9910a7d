// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/import/detector_noise.h"
#include "mrpt_plugins/import/log_writer.h"
#include "mrpt_plugins/import/noisy_motion.h"

namespace HYBRID_API hybrid {

/// KITTI tracking: labelled objects of several classes, standing or moving, seen from a car.
struct KittiTrackingOptions {
  std::string
      labels;  ///< KITTI's label file: frame track class truncated occluded alpha box size X Y Z ry
  std::string poses;  ///< Poses of the camera, a 3x4 matrix per row.
  /// Factor of the translations of the poses, where they and the labels disagree in scale; 0: the
  /// one at which what stands is seen in one place.
  double pose_scale = 0;
  MotionNoise noise{0.03, 0.002, 1};  ///< Given to the odometry, which is the motion of the poses.
  double period = 0.1;                ///< Between frames [s].
  double max_range = 60;              ///< Objects farther away are dropped [m].
  /// What labels of one car at different times disagree by. Their errors are alike over about half
  /// a second: keyframes nearer in time tell nothing new.
  DetectorNoise detector{0.2, 0, 0.004, 0.06};
  double still_rms =
      1.0;  ///< Tracks that spread more about their mean move: they have no true id [m].
  double class_accuracy = 1.0;  ///< Share of detections that keep their class; the others get any.
};

/// Converts a sequence into a planar log with a step for each frame. Ids are track numbers of
/// objects that stand still; moving ones are in the log as detections without an id. The true map
/// holds the mean places of the former.
ImportReport import_kitti_tracking(const KittiTrackingOptions& options, const std::string& output);

}  // namespace hybrid
