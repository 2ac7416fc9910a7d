// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace hybrid {

/// The ending of a name in small letters, as ".bin".
std::string extension_of(const std::string& name);

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

}  // namespace hybrid
