// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/import/detection_options.h"

namespace hybrid {

inline constexpr std::int64_t kNoClass = -1;
inline constexpr std::int64_t kMostImages = 1'000'000'000;

struct ImageBox {
  std::int64_t image = 0;
  std::int64_t category = kNoClass;
  double left = 0, top = 0, width = 0, height = 0;  // [pixels]
  double score = 1;
};

/// What is read of boxes in images.
struct ImageBoxes {
  std::vector<ImageBox> all;
  std::map<std::int64_t, std::string> images;  // by number, with their names where they have any;
                                               // also those without boxes
  std::map<std::int64_t, double> stamps;       // [s], of images whose names are times
  std::map<std::int64_t, std::string> classes;

  /// Throws Error if an image of another name has the number.
  void add(const std::string& path, std::int64_t image, const std::string& name);
};

/// The time [s] that a name is, in seconds with decimals or in whole s, ms, us or ns since 1970.
std::optional<double> stamp_in(const std::string& name);

/// The boxes of a folder of YOLO, of COCO results or of det.txt of MOT, in the order of the images.
ImageBoxes read_image_boxes(const DetectionTablesOptions& options);

}  // namespace hybrid
