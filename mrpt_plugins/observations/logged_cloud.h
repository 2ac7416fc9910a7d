// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservationPointCloud.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// What a file beside a log has of a cloud.
enum class CloudForm : std::uint8_t {
  kNone,         ///< from here as MRPT numbers the forms of a CObservationPointCloud
  kMrpt,         ///< a map of points, as MRPT serialises it
  kKitti,        ///< KITTI's form
  kText,         ///< rows of text
  kCoordinates,  ///< of a CObservation3DRangeScan the points
  kRanges,       ///< its range image
  kUnknown
};

/// What makes points of a range image.
struct DepthCamera {
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< [pixels]
  std::array<double, 8> distortion{};     ///< k1 k2 p1 p2 k3 k4 k5 k6 of OpenCV
  double unit = 0.001;                    ///< of its numbers [m]
  bool is_depth = true;                   ///< along the axis of the camera, not along the ray
};

/// A cloud of a log, of whatever class, whose points may have times. In memory only: MRPT knows it
/// as the class that it derives from, and writes no times of it.
class LoggedCloud : public mrpt::obs::CObservationPointCloud {
 public:
  /// When each point was seen, relative to the timestamp [s]; empty where that is not known.
  std::vector<float> times;
  /// Where `pointcloud` is null, the file beside the log that has the points, as the log names it,
  /// and its form. Not by MRPT's own members, so that nothing of MRPT opens it.
  std::string file;
  CloudForm form = CloudForm::kNone;
  DepthCamera camera;  ///< where the form is kRanges
  /// Why there are no points, where that is known.
  std::string fault;
};

}  // namespace hybrid
