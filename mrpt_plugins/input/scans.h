// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservation2DRangeScan.h>

#include <cstddef>
#include <optional>
#include <vector>

#include "libhybrid/scans/laser_scan.h"
#include "mrpt_plugins/input/rawlog_reader.h"

namespace HYBRID_API hybrid {

/// How planar laser scans of a log are read.
struct ScanOptions {
  double max_range = 1000.0;  ///< Rays at or beyond see nothing [m].
  /// Used in place of the field of view of the log, where positive [rad].
  double field_of_view = 0;
};

/// The scan in a CObservation2DRangeScan; nothing for other classes. Its time is left at 0.
///
/// The rays are spread over the field of view as MRPT spreads them: the first and the last are at
/// its borders. Rays that are invalid, zero, negative, not finite, or at the maximum range of the
/// sensor or of the options or beyond, see nothing: they become NaN.
///
/// Dropped, and counted in `report` by reason: scans without a ray; of several rays whose field of
/// view is not in (0, 2 pi]; of a sensor that tilts while it sweeps; with a sensor pose that is not
/// finite, no rigid motion, or farther from the robot than the maximum range of the options; of a
/// laser that is not level, by more than 15 degrees.
std::optional<LaserScan> scan_in(const mrpt::obs::CObservation& observation,
                                 const ScanOptions& options, DropReport& report);

/// The reverse, for MRPT's maps. Its scans look straight ahead in the middle: what is not symmetric
/// turns the sensor about its axis.
mrpt::obs::CObservation2DRangeScan::Ptr to_mrpt(const LaserScan& scan);

/// Whether an observation is a scan as imports of CARMEN logs leave it that take each ray for half
/// a degree where it is a whole one: 180 rays over 90 degrees.
bool is_halved_scan(const mrpt::obs::CObservation& observation);

/// The scans between keyframes, placed by odometry.
class ScanCollector {
 public:
  /// Of more scans than this between two keyframes, those of every second step are left out, then
  /// of every fourth and so on: the robot stands still or nearly so, and each takes some kilobytes.
  static constexpr std::size_t kMost = 256;

  /// The robot moved to the next step; nothing where odometry does not tell. Scans from before a
  /// gap are dropped, since their place is not known.
  void move(const std::optional<OdometryIncrement>& odometry, DropReport& report);
  /// Takes a scan of this step.
  void add(LaserScan scan, DropReport& report);
  bool empty() const { return scans_.empty(); }
  /// The scan of this step that was taken last; null where it has none.
  const LaserScan* newest() const {
    return !scans_.empty() && scans_.back().step == step_ ? &scans_.back().scan : nullptr;
  }
  /// This step is a keyframe: the scans since the one before, placed in its frame.
  std::vector<LaserScan> release();

 private:
  struct Collected {
    std::size_t step = 0;
    LaserScan scan;  // with the pose since the last keyframe
  };
  bool is_left_out(const Collected& collected) const;
  void thin_out(DropReport& report);

  std::vector<Collected> scans_;
  std::size_t step_ = 0;                                                // since the last keyframe
  std::size_t stride_ = 1;                                              // of steps that are kept
  Eigen::Isometry3d T_keyframe_robot_ = Eigen::Isometry3d::Identity();  // since the last keyframe
};

}  // namespace hybrid
