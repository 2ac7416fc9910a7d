// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/scans/scan_points.h"

namespace HYBRID_API hybrid {

/// Notices that a robot is moved while its odometry rests: it is carried, or its wheels do not
/// count. The scans of a robot that rests are the same but for noise and for what moves around it.
class RestWatch {
 public:
  /// The next scan, in the frame of the robot, and the motion to it by odometry. Whether odometry
  /// rests, and a quarter of the points are where the scan before had none, however that is aligned
  /// nearby. A scan of n points takes n^2 comparisons, where odometry rests.
  bool is_moved(const std::vector<SurfacePoint>& points, const std::optional<SE2>& odometry);

 private:
  std::shared_ptr<const std::vector<SurfacePoint>> before_;  // of the last scan
};

}  // namespace hybrid
