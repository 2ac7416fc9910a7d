// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "libhybrid/io/read_points.h"
#include "mrpt_plugins/observations/logged_cloud.h"

namespace hybrid {

/// A range image, row by row from the top.
struct RangeImage {
  std::size_t rows = 0, columns = 0;
  std::vector<float> ranges;  ///< not positive where nothing was seen
  bool is_metric = false;     ///< in metres, not in units of the camera
};

/// The points that a CObservation3DRangeScan keeps in a file: their x, y and z, as binary numbers,
/// plain or compressed, or as text, F.txt. Throws Error where the file is none, damaged, or of more
/// than ten million points.
PointFile read_coordinates(const std::string& path);

/// The range image that it keeps in a file, in the same way; that of MRPT before 2.1, too, which is
/// in metres.
RangeImage read_ranges(const std::string& path);

/// The points that a camera saw, x ahead, as MRPT unprojects them: all but those without a range.
PointFile unprojected(const RangeImage& image, const DepthCamera& camera);

}  // namespace hybrid
