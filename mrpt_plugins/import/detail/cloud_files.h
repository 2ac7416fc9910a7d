// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "libhybrid/geometry/points.h"
#include "mrpt_plugins/import/clouds.h"
#include "mrpt_plugins/rawlog/image_decoder.h"

namespace hybrid {

/// Whether name `a` comes before `b` where runs of digits count as numbers: 2 before 10.
bool is_before(const std::string& a, const std::string& b);

/// The files of a folder that hold clouds.
struct CloudFolder {
  std::vector<std::string> clouds;  // paths, in natural order, or that of their times
  std::vector<double> stamps;       // [s], where all names are times
  bool are_images = false;          // depth images
  std::size_t others = 0;           // files that are none
  std::string another;              // name of one of these
};

/// Where a folder has clouds of a lidar, its images are other files. Throws Error where it has no
/// cloud.
CloudFolder clouds_in(const std::string& folder);

/// The points of a file.
struct CloudPoints {
  Points points;               // x ahead, y to the left, z up, of the sensor [m]
  std::vector<double> times;   // of each, as the file has them [s], or none
  std::size_t not_finite = 0;  // points left out
  std::size_t too_far = 0;     // beyond the maximum range
};

/// Reads clouds one by one.
class CloudFiles {
 public:
  /// Throws Error where something of the options does not fit.
  CloudFiles(const CloudsOptions& options, bool are_images);

  /// Throws Error that names the file where it cannot be read.
  CloudPoints read(const std::string& path);

 private:
  CloudPoints read_depths(const std::string& path);

  const CloudsOptions& options_;
  bool are_images_;
  DepthDecoder decoder_;
};

}  // namespace hybrid
