// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/import/detector_noise.h"
#include "mrpt_plugins/import/log_writer.h"
#include "mrpt_plugins/import/noisy_motion.h"

namespace HYBRID_API hybrid {

/// KITTI tracking: labelled objects of several classes, static or moving, seen from a car.
struct KittiTrackingOptions {
  std::string
      labels;  ///< KITTI's label file: frame track class truncated occluded alpha box size X Y Z ry
  std::string poses;  ///< Poses of the camera, a 3x4 matrix per row.
  /// Scale factor of the translations of the poses, which may disagree with that of the labels. 0:
  /// the one that minimises the spread of static objects.
  double pose_scale = 0;
  MotionNoise noise{0.03, 0.002, 1};  ///< Added to the motions of the poses, which are the
                                      ///< odometry.
  double period = 0.1;                ///< Between frames [s].
  double max_range = 60;              ///< Objects farther away are dropped [m].
  /// Disagreement of labels of one car at different times. Their errors are correlated over about
  /// half a second, so that keyframes closer in time add no information.
  DetectorNoise detector{0.2, 0, 0.004, 0.06};
  double still_rms = 1.0;  ///< RMS distance to the mean above which an object counts as moving and
                           ///< has no id [m].
  double class_accuracy = 1.0;  ///< Share of detections with the true class; the others get a
                                ///< random one.
};

/// Converts a sequence into a planar log with one step per frame. Ids are the track numbers of
/// static objects; detections of moving ones are in the log without an id, but for their true one.
/// The true map holds the mean positions of the static objects, and the truth of movers the places
/// of the others. Tracks of fewer than three labels are of neither.
ImportReport import_kitti_tracking(const KittiTrackingOptions& options, const std::string& output);

}  // namespace hybrid
