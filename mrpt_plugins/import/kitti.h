// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/import/log_writer.h"

namespace HYBRID_API hybrid {

/// KITTI odometry: visual odometry, boxes of an object detector on the left image, calibration.
struct KittiOptions {
  /// Odometry in the plane, lines EDGE_SE2 i i+1 ... of a g2o file; or poses in space, a 3x4 matrix
  /// per row (.txt).
  std::string odometry;
  /// For poses in space: 21 numbers per row, the upper triangle of the covariance of each motion
  /// over (translation, rotation), left perturbation of the inverse motion. Empty: sigmas of 0.03 m
  /// and 0.002 rad.
  std::string covariances;
  double inflate = 6;      ///< Factor of the standard deviations of those covariances.
  std::string boxes;       ///< Rows frame x_min y_min width height coco_class confidence [pixels].
  std::string truth;       ///< True poses, a 3x4 matrix per row; empty: unknown.
  double period = 0.1036;  ///< Between frames [s].
  /// Focal length and centre of the rectified left camera [pixels]; of sequences 00 to 02.
  double focal = 718.856, center_u = 607.1928, center_v = 185.2157;
  double camera_height = 1.65;                      ///< Above the road [m].
  double object_height = 1.5, sigma_height = 0.07;  ///< Of the cars [m].
  double half_length = 2;   ///< From the side seen to the middle of a car [m].
  double max_depth = 25;    ///< Boxes farther away are dropped [m].
  double agreement = 0.35;  ///< Boxes whose depths by height and by road differ more are dropped.
  /// Radius in which sightings, put into place by the true poses, are taken for one car [m]; their
  /// number becomes their true id, for comparison. 0: no true ids.
  double oracle_radius = 0;
};

/// Converts a sequence into a log with a step for each image. The robot is the left camera, turned
/// so that x points ahead and z up. The depth of a box is that where a car of the usual height
/// fills it and where its lower edge meets the road, weighted by their noise.
ImportReport import_kitti(const KittiOptions& options, const std::string& output);

}  // namespace hybrid
