// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/math/TPoint3D.h>
#include <mrpt/obs/CObservation.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/input/arrival_order.h"
#include "mrpt_plugins/input/odometry.h"
#include "mrpt_plugins/input/odometry_gap.h"
#include "mrpt_plugins/input/odometry_reading.h"
#include "mrpt_plugins/input/odometry_reset.h"
#include "mrpt_plugins/input/odometry_stop.h"
#include "mrpt_plugins/input/poses_between.h"
#include "mrpt_plugins/rawlog/object_reader.h"

namespace HYBRID_API hybrid {

/// Number of dropped or repaired entries by reason.
using DropReport = std::map<std::string, std::size_t>;

/// One step of the robot: its observations, and the motion to it.
struct LogStep {
  /// Counts from 0; row i of MRPT's ground truth path belongs to step i.
  std::size_t index = 0;
  double time = 0;  ///< [s] since 1970, or synthesised (see RawlogReader).
  /// Motion since the last step. On the first step: motion before it, if the log has any. Absent if
  /// the odometry is missing or unusable.
  std::optional<OdometryIncrement> odometry;
  /// Entries of the odometry since the last step, up to the time of this one, seen from it. None
  /// where the motion is not known.
  std::vector<PoseBetween> between;
  /// Observations of classes that this program knows or that were requested.
  std::vector<mrpt::obs::CObservation::Ptr> observations;
  std::vector<mrpt::math::TPoint3Df> points;  ///< of all observations [m], if requested
};

struct RawlogOptions {
  /// Noise of CObservationOdometry, which has none.
  MotionModel motion_model;
  double clock_offset = 0;  ///< Added to the time stamps of the log [s].
  /// Time between frames without a valid timestamp [s].
  double period = 1.0;
  /// Odometry that is faster over the time of a step, or over a period if that is longer, counts as
  /// damaged [m/s].
  double max_speed = 100.0;
  /// Single observations are put in the order of their stamps where they arrive at most so much
  /// later than others [s]; never those of standard input, where nothing is to wait.
  double arrival_window = 2.0;
  /// Further classes of observations to read, and libraries that define them.
  LogRequest request = {};
  std::vector<std::string> libraries = {};
};

/// Streams a rawlog of either format as steps.
///
/// Actions and sensory frames: a step is a sensory frame, reached by the actions since the last
/// one. A log may begin with a sensory frame, which is step 0 (MRPT's own pair reader drops it).
/// Actions after the last frame make no step. Single readings of odometry between frames make none
/// either: they tell where the robot was between two frames that have a reading of their own time.
///
/// Observations only: they are put in the order of their stamps, as far as they arrive within a
/// window; equal stamps keep the order of the file. Observations with one timestamp make a step.
/// Its pose is interpolated between the CObservationOdometry before and after it, and is that of
/// the nearest one up to twice the time between two beyond their ends; further, the motion is not
/// known.
/// CObservationRobotPose is taken for odometry where the log has no other. Observations that nobody
/// asked for make no step, unless the log has no others. Where odometry starts anew, the motion is
/// not known.
///
/// Frames without a valid timestamp get that of the last frame plus the period, the first one 0.
/// Where time goes backwards, frames are kept in the order of the file with the time of the last
/// frame; single observations and odometry readings that are later than the window are dropped.
/// Gaps of over ten times the usual period are counted as missing frames: the odometry across them
/// is used unchanged.
class RawlogReader {
 public:
  /// Throws Error if the file is missing or cannot be opened.
  explicit RawlogReader(const std::string& path, const RawlogOptions& options = {});

  /// The next step, or nothing at the end; then status() is how the log ended.
  std::optional<LogStep> next();
  /// At the end of the log: the entries of the odometry after the last step, seen from it.
  std::vector<PoseBetween> rest() const;

  LogStatus status() const { return objects_.status(); }
  /// One line on how the log ended; empty if complete.
  const std::string& message() const { return objects_.message(); }
  std::optional<double> progress() const { return objects_.progress(); }
  std::uint64_t objects() const { return objects_.objects(); }
  /// Problems in the log that were handled: bad odometry, missing timestamps, unused objects.
  DropReport warnings() const;
  /// Share of the stamps of the odometry that are that of the one before; 0 if the robot does not
  /// move from one to the next.
  double repeated_stamps() const;
  /// How often the odometry has stood still as no robot does, see OdometryStop.
  std::size_t odometry_stops() const { return stop_.count(); }
  /// Observations read so far by class, without namespace, used or not.
  const std::map<std::string, std::size_t>& observations() const { return observations_; }

 private:
  struct TimedOdometry {
    double time;
    OdometryReading pose;
  };

  void take(const LoggedActions& actions);
  void take(const LoggedFrame& frame);
  void take(const LoggedObservation& observation);
  void take(const LoggedPoints&) {}
  void take(const OtherObject& other);
  void take_in_order(const LoggedObservation& observation);
  std::optional<OdometryReading> pose_in(const LoggedObservation& observation);
  void take_odometry(mrpt::system::TTimeStamp stamp, const OdometryReading& pose);
  void start_odometry_anew();
  void drain(bool all);
  void move_to(LogStep& step, const OdometryReading& pose);
  void move_by_actions(LogStep& step);
  void note_action();
  void release_until(double time);
  void release_front();
  void emit(LogStep step);
  double reach(double time) const;
  bool is_within_reach(const TimedOdometry& before, const TimedOdometry& after) const;
  bool is_beyond_odometry(double time) const;
  bool is_in_gap(double time) const;
  void drop_implausible(LogStep& step);
  double time_of(mrpt::system::TTimeStamp stamp);
  double advance_to(double time);
  std::optional<OdometryIncrement> checked(std::optional<OdometryIncrement> odometry);

  ObjectReader objects_;
  RawlogOptions options_;
  DropReport warnings_;
  std::map<std::string, std::size_t> observations_;
  std::deque<LogStep> ready_;
  std::size_t emitted_ = 0;
  double emitted_time_ = 0;  // of the last emitted step
  double last_time_;
  double usual_gap_ = 0;  // running mean of the time between frames
  bool started_ = false;

  // Pairs.
  std::optional<OdometryIncrement> motion_;  // since the last frame
  bool motion_is_known_ = true;              // no part of it was dropped
  mrpt::system::TTimeStamp action_stamp_;
  bool acts_ = false;                                                // actions tell motions
  Eigen::Isometry3d T_start_frame_ = Eigen::Isometry3d::Identity();  // by actions
  PosesBetween actions_;
  OdometryStop stop_;  // by actions, or readings where there are none

  // Observations only.
  std::deque<LogStep> waiting_;  // for later odometry
  std::optional<TimedOdometry> before_, after_;
  OdometryGap gap_;
  bool has_gap_ = false;                      // poses are missing between those two
  std::optional<OdometryReading> last_pose_;  // odometry at the last released step
  PosesBetween between_;
  ArrivalOrder<LoggedObservation> arrivals_;
  std::optional<double> unused_;  // time of the first observation that nobody asked for
  bool has_odometry_ = false;     // of its own kind, so that poses of the robot are none
  OdometryReset reset_;
  std::size_t readings_ = 0, repeated_ = 0;  // of odometry; with the stamp of the one before
  bool moves_at_once_ = false;               // at one stamp
};

}  // namespace hybrid
