// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/import/log_writer.h"
#include "mrpt_plugins/import/velocity_odometry.h"

namespace HYBRID_API hybrid {

/// A log of CARMEN with a laser range finder, as the Robotics Data Set Repository has them.
struct CarmenOptions {
  std::string file;  ///< F.clf, also compressed by bzip2, gzip or Zstandard
  /// Angle that the rays of FLASER lines cover [deg]; 0: as PARAM lines say, by the resolution or
  /// the field of view of the front laser, else 180.
  double fov_deg = 0;
  double max_range = 0;  ///< where the sensor sees nothing [m]; 0: as the log says, else 80
  /// Noise of the odometry, of which the log says nothing.
  OdometryWalk walk{0.05, 0.05, 0.02, 0.05, 1e-3};
};

/// Converts a log into a planar one with one step per scan: the front laser of FLASER, ROBOTLASER1
/// and RAWLASER1 lines, with the odometry in the same line or, for RAWLASER1, of the ODOM lines
/// around its time; that of the ODOM line before where their times are not of one clock or go back.
/// A log of RAWLASER1 lines without any becomes one of scans alone. Other lines are left out. A
/// last line that is cut off is, too, which is noted.
///
/// The first pose of FLASER lines is that of the laser: where it keeps its place on the robot, the
/// second pose, that place is used in place of what PARAM lines say. In ROBOTLASER1 lines, too, it
/// is used where the laser keeps it, else what PARAM lines say, which is noted. A largest range
/// that is infinite or 0 is none, and ranges that are not finite are of rays that saw nothing.
///
/// FLASER lines tell no angles: with an even number of rays over 180 degrees the first is at -90
/// degrees and the last one step before 90, as CARMEN has them, with an odd number it is at 90.
/// The order of the file counts: a time stamp that goes back, as some loggers write, becomes that
/// of the scan before. Throws Error that names file, line and column for a line that cannot be
/// read, and for a file without scans.
ImportReport import_carmen(const CarmenOptions& options, const std::string& output);

}  // namespace hybrid
