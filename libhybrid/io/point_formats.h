// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "libhybrid/geometry/points.h"
#include "libhybrid/io/binary_number.h"
#include "libhybrid/io/text_reader.h"

namespace HYBRID_API hybrid {

/// The points of a file.
struct PointFile {
  Points points;
  /// When each was seen [s], NaN where that is not known; empty where the file has no times.
  std::vector<double> times;
  std::size_t left_out = 0;  ///< points with a coordinate that is not finite
};

/// Adds the point whose x, y and z are these words of a row, or counts it in `left_out` if one is
/// NaN or infinite, as for a ray without return. Throws Error for a word that is no number or
/// beyond kLargestCoordinate.
void add_point(PointFile& file, const TextRow& row, const std::array<std::size_t, 3>& xyz);

/// The same for a point of binary data; throws Error beginning with `where`.
void add_point(PointFile& file, const Eigen::Vector3d& point, const std::string& where);

/// Whether a field of this name holds the time of a point.
bool is_time_field(std::string_view name);

/// Adds the time of the point that was added last, unless that was left out: a floating number in
/// seconds, a whole one in nanoseconds.
void add_time(PointFile& file, double value, BinaryNumber type);

/// The same for a word of a row; throws Error where it is no number.
void add_time(PointFile& file, const TextRow& row, std::size_t i, BinaryNumber type);

/// Rows of at least three columns: x y z, and what else a point has.
PointFile read_rows(const std::string& path);
/// KITTI's form: x y z and intensity of each point, 32 bits each.
PointFile read_kitti(const std::string& path);
PointFile read_ply(const std::string& path);
PointFile read_pcd(const std::string& path);

}  // namespace hybrid
