// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <optional>
#include <string>
#include <vector>

namespace hybrid {

/// A pose of a file, in its axes.
struct PoseRow {
  std::optional<double> time;  // [s]; for all poses of a file or for none
  mrpt::poses::CPose3D pose;
};

/// Reads poses of others, told apart by the number of columns of the first row, or by its first
/// word as g2o: then the poses are those that its odometry leads to, by ascending ids, without
/// times.
///
///  8  TUM: time x y z qx qy qz qw
/// 12  KITTI: a 3x4 matrix, row by row
/// 16  a 4x4 matrix, row by row
/// 17  the number of an image, and a 4x4 matrix
///  4  a 4x4 matrix in four rows, whose last number is 1, or in all matrices their time
///
/// Throws Error "file:line:column: what" for any other row, a rotation that is none, and times that
/// decrease.
std::vector<PoseRow> read_pose_rows(const std::string& path);

}  // namespace hybrid
