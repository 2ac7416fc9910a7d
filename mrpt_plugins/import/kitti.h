// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/import/log_writer.h"

namespace HYBRID_API hybrid {

/// KITTI odometry: visual odometry, boxes of an object detector on the left image, calibration.
struct KittiOptions {
  /// Planar odometry, lines EDGE_SE2 i i+1 ... of a g2o file; or 3-D poses, one 3x4 matrix per row
  /// (.txt).
  std::string odometry;
  /// For 3-D poses: 21 numbers per row, the upper triangle of the covariance of each motion over
  /// (translation, rotation), as a left perturbation of the inverse motion. Empty: sigmas of 0.03 m
  /// and 0.002 rad.
  std::string covariances;
  double inflate = 6;      ///< Factor of the standard deviations of those covariances.
  std::string boxes;       ///< Rows frame x_min y_min width height coco_class confidence [pixels].
  std::string truth;       ///< True poses, one 3x4 matrix per row; empty: unknown.
  double period = 0.1036;  ///< Between frames [s].
  /// Focal length and principal point of the rectified left camera [pixels]; defaults of sequences
  /// 00 to 02.
  double focal = 718.856, center_u = 607.1928, center_v = 185.2157;
  double camera_height = 1.65;                      ///< Above the road [m].
  double object_height = 1.5, sigma_height = 0.07;  ///< Of the cars [m].
  double half_length = 2;   ///< From the visible surface to the centre of a car [m].
  double max_depth = 25;    ///< Boxes farther away are dropped [m].
  double agreement = 0.35;  ///< Largest relative difference of the depths by height and by road;
                            ///< other boxes are dropped.
  /// Radius within which sightings, placed by the true poses, belong to one car [m]. Its number is
  /// their true id, for evaluation. 0: no true ids.
  double oracle_radius = 0;
};

/// Converts a sequence into a log with one step per image. The robot frame is that of the left
/// camera, turned so that x points ahead and z up. The depth of a box is the weighted mean of two
/// estimates: by the height of the box for a car of the usual height, and by its lower edge on the
/// road plane. The weights are the inverse variances.
ImportReport import_kitti(const KittiOptions& options, const std::string& output);

}  // namespace hybrid
