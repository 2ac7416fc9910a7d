// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/io/text_reader.h"
#include "mrpt_plugins/import/kitti.h"

namespace hybrid {

/// A car seen in an image.
struct BoxSighting {
  CObservationClassedBearingRange::Detection detection;
  Eigen::Vector3d point;  ///< Middle of the car in the frame of the robot [m].
};

/// Names of the classes a box can have.
const std::vector<std::string>& kitti_box_classes();

/// Streams the boxes that tell where a car is, in order of images; the others are counted.
class Boxes {
 public:
  /// Throws Error for a missing file.
  Boxes(const KittiOptions& options, bool is_3d, DropReport& dropped);

  /// Those of an image, which come one after the other. Throws Error with file:line for anything
  /// malformed.
  std::vector<BoxSighting> of(std::size_t frame);

  /// Throws Error if there are boxes of images after the last one asked for.
  void finish() const;

 private:
  void advance();
  std::optional<BoxSighting> sighting();

  const KittiOptions& options_;
  bool is_3d_;
  DropReport& dropped_;
  TextReader table_;
  std::optional<TextRow> row_;
};

}  // namespace hybrid
