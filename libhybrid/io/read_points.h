// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <string>

#include "libhybrid/geometry/points.h"

namespace hybrid {

/// The points of a file, and how many were left out because a coordinate is not finite.
struct PointFile {
  Points points;
  std::size_t left_out = 0;
};

/// Reads x y z of a point cloud: .ply (text or binary), .pcd (text), .xyz, .txt, .asc or .csv (rows
/// of at least three numbers; '#' begins a comment). Throws Error naming file and line where it is
/// missing, of another format, malformed, or holds fewer points than its header says.
PointFile read_points(const std::string& path);

/// Whether `path` has one of these extensions.
bool is_point_file(const std::string& path);

}  // namespace hybrid
