// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservation.h>

#include <optional>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/input/rawlog_reader.h"

namespace HYBRID_API hybrid {

/// Points that a lidar or a depth camera saw, in the frame that the robot had then [m].
struct PointCloud {
  std::vector<Eigen::Vector3f> points;
  /// When each was seen, relative to the stamp [s]; empty where that is not known, and not finite
  /// for a point of which it is not.
  std::vector<float> times;
  double stamp = 0;                                  ///< [s] since 1970
  Eigen::Vector3f sensor = Eigen::Vector3f::Zero();  ///< where they were seen from
};

/// Whether an observation is a CObservationPointCloud.
bool is_cloud(const mrpt::obs::CObservation& observation);

/// Whether it is one that was read, of which no point is finite: its sensor saw nothing.
bool is_empty_cloud(const mrpt::obs::CObservation& observation);

/// The cloud in a CObservationPointCloud; nothing for other classes.
///
/// Dropped, and counted in `report` by reason: clouds whose points are in a file beside the log
/// that was not read, that have no finite one, or whose sensor pose is not finite or farther than
/// 1 km from the robot. Times of another number than the points are dropped and counted alone.
std::optional<PointCloud> cloud_in(const mrpt::obs::CObservation& observation, DropReport& report);

}  // namespace hybrid
