// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libhybrid/geometry/se3.h"

namespace HYBRID_API hybrid {

/// The detections of one static object, frame by frame.
struct ObjectTrack {
  std::string name;
  std::vector<std::optional<SE3>> sightings;  ///< T_camera_object; empty if not detected
  std::vector<std::optional<SE3>> truth;      ///< true T_camera_object; empty if there is no file
};

/// A camera that sees objects: one entry per frame everywhere, lengths in metres.
struct ObjectSequence {
  std::vector<double> times;  ///< s
  std::vector<SE3> odometry;  ///< T_odometry_camera
  std::vector<SE3> truth;     ///< T_world_camera; empty if there is no file
  std::vector<ObjectTrack> objects;
};

/// Reads a folder of text files, one row `t x y z qx qy qz qw` per frame: odom.txt, the path by
/// odometry; det_NAME.txt, sightings of object NAME, a quaternion of zeros where it was not
/// detected; and optionally cam_gt.txt and objgt_NAME.txt, the truth of both. Objects are in order
/// of name. Throws Error that names file and line for what cannot be read, rows that do not fit
/// odom.txt, or a folder without sightings.
ObjectSequence read_object_sequence(const std::string& folder);

}  // namespace hybrid
