// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/io/text_row.h"
#include "mrpt_plugins/bridge/timed_pose.h"

namespace HYBRID_API hybrid {

/// A true landmark.
struct LandmarkTruth {
  std::int64_t id = 0;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m], map frame.
  std::string class_name;                              ///< Empty if the file has none.
};

// All readers skip empty lines and comments (`%` or `#` to the end of the line). They throw Error
// "file:line:column: what" for any other deviation from the format, and for a file without rows.

/// MRPT's `_ground_truth.txt`: rows `x y z 5 0 0 ID`, optionally followed by the class, a name or
/// the index into the names of a comment line `% classes: name name ...`; or as MRPT's beacon maps,
/// rows `ID x y z` and eight zeros.
std::vector<LandmarkTruth> read_true_landmarks(const std::string& path);

/// MRPT's `_ground_truth_robot_path.txt`: rows `x y z yaw pitch roll` [m, rad]; row i belongs to
/// step i of the log.
std::vector<mrpt::poses::CPose3D> read_true_path(const std::string& path);

/// Whether a file is one for read_numbered_path(): its first row has four numbers.
bool is_numbered_path(const std::string& path);
/// MRPT's `_GT.txt`: rows `step x y yaw` [m, rad], of steps 0, 1 and so on; those after the last
/// row are not known.
std::vector<mrpt::poses::CPose3D> read_numbered_path(const std::string& path);

/// TUM trajectories: rows `time x y z qx qy qz qw`, quaternions of norm 1 within 1 %, times not
/// decreasing.
std::vector<TimedPose> read_tum(const std::string& path);

/// The pose of a row whose quaternion begins at the words `x` to `x + 3` as qx qy qz qw. Throws
/// Error unless its norm is 1 within 1 %.
mrpt::poses::CPose3D pose_in(const TextRow& row, const Eigen::Vector3d& position,
                             const std::array<std::size_t, 4>& quaternion);

/// Whether rotations read as qx qy qz qw seem to be written qw qx qy qz: with the real part first
/// nearly all are upright, and as they are read few are.
bool seems_real_part_first(const std::vector<TimedPose>& poses);
/// What is said then of a file.
std::string about_real_part_first(const std::string& path);

/// Positions without orientation, such as those of a satellite receiver: rows `time x y z`, times
/// not decreasing. The rotation of the poses is the identity and has no meaning.
std::vector<TimedPose> read_positions(const std::string& path);

}  // namespace hybrid
