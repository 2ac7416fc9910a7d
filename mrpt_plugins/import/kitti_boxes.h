// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/import/kitti.h"

namespace hybrid {

/// A car seen in an image.
struct BoxSighting {
  std::size_t frame = 0;
  CObservationClassedBearingRange::Detection detection;
  Eigen::Vector3d point;  ///< Middle of the car in the frame of the robot [m].
};

/// Names of the classes a box can have.
const std::vector<std::string>& kitti_box_classes();

/// The boxes that tell where a car is, in order of frames; the others are counted in `log`.
std::vector<BoxSighting> read_boxes(const KittiOptions& options, bool is_3d, LogWriter& log);

}  // namespace hybrid
