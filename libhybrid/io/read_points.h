// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/io/point_formats.h"

namespace HYBRID_API hybrid {

/// Reads x y z of a point cloud: .ply (text or binary), .pcd (text, binary or
/// compressed), .xyz, .txt, .asc or .csv (rows
/// of at least three columns, as many in each, cut as TextFormat::Cut::kCells; '#' begins a
/// comment). Times of points are read of .ply and .pcd: a field t, time, timestamp or offset_time,
/// in seconds where it is floating, in nanoseconds where it is whole. Throws Error naming file and
/// line if the file is missing, of another format, malformed, or has fewer or more points than its
/// header says, or a coordinate beyond kLargestCoordinate.
PointFile read_points(const std::string& path);

/// The same, but a file may hold no point, or none that is finite, as a scan that met nothing.
PointFile read_cloud(const std::string& path);

/// Whether `path` has the extension of one of these formats.
bool is_point_file(const std::string& path);

}  // namespace hybrid
