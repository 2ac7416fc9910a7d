// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservation.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/fixes/fix.h"
#include "mrpt_plugins/bridge/geodesy.h"
#include "mrpt_plugins/input/rawlog_reader.h"

namespace HYBRID_API hybrid {

/// A fix of a log, not yet in the axes of a datum: `fix.position` is left at 0.
struct LoggedFix {
  Fix fix;
  GeodeticPoint place;
  bool is_on_earth = true;  ///< else latitudes stand for coordinates of another frame
};

/// The fix in a CObservationGPS; nothing for other classes. Its sigma is that which the receiver
/// states, or else what its quality is known for, times the dilution of precision.
///
/// Dropped, and counted in `report` by reason: fixes that the receiver calls invalid, that are not
/// finite, at latitude and longitude zero, or of an antenna farther than 1 km from the robot.
std::optional<LoggedFix> fix_in(const mrpt::obs::CObservation& observation, DropReport& report);

/// Tells where one of the receivers gives its last fix once more, with a new stamp.
class RepeatedFixes {
 public:
  bool is_repeated(const LoggedFix& fix);

 private:
  std::map<std::string, GeodeticPoint> last_;  // by label
};

/// Puts fixes into the axes of a datum: the first fix that the next one confirms.
class DatumFinder {
 public:
  DatumFinder() = default;
  /// One that is known.
  DatumFinder(const GeodeticPoint& datum, bool is_on_earth)
      : frame_(datum), is_on_earth_(is_on_earth) {}

  /// East, north, up [m]; nothing, which is counted in `report`, before there is a datum, and for
  /// fixes farther than 1,000 km from it.
  std::optional<Eigen::Vector3d> to_local(const LoggedFix& fix, DropReport& report);

  const std::optional<LocalFrame>& frame() const { return frame_; }
  bool is_on_earth() const { return is_on_earth_; }
  /// Whether most fixes are farther than that: the datum is a false one.
  bool is_contradicted() const { return far_ > near_; }

 private:
  bool confirms(const LoggedFix& fix);

  std::optional<LoggedFix> first_;  // that waits to be confirmed
  std::optional<LocalFrame> frame_;
  bool is_on_earth_ = true;
  std::size_t near_ = 0, far_ = 0;
};

/// The fixes between keyframes, placed by odometry.
class FixCollector {
 public:
  /// The robot moved to the next step [s]; nothing where odometry does not tell.
  void move(double time, const std::optional<OdometryIncrement>& odometry, DropReport& report);
  /// Takes a fix that came with this step. Where its own time is another, it is placed by it.
  void add(LoggedFix fix, DropReport& report);
  /// This step is a keyframe: the fixes since the one before, placed in its frame.
  std::vector<LoggedFix> release();

 private:
  std::vector<LoggedFix> fixes_;  // with the pose since the last keyframe
  RepeatedFixes repeats_;
  std::size_t rows_ = 0;
  double time_ = 0, time_before_ = 0;
  Eigen::Isometry3d T_keyframe_robot_ = Eigen::Isometry3d::Identity();
  Eigen::Isometry3d T_before_now_ = Eigen::Isometry3d::Identity();  // of the last step
};

}  // namespace hybrid
