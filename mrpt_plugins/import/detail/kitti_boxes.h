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

/// Streams the boxes that determine the position of a car, in order of images. Counts the others in
/// `dropped`.
class Boxes {
 public:
  /// Throws Error for a missing file.
  Boxes(const KittiOptions& options, bool is_3d, DropReport& dropped);

  /// The boxes of one image; images must be asked for in order. Throws Error with file:line for
  /// malformed rows.
  std::vector<BoxSighting> of(std::size_t frame);

  /// Throws Error if there are boxes of later images.
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
