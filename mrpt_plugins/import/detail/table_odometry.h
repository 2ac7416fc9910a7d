// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mrpt_plugins/bridge/timed_pose.h"
#include "mrpt_plugins/import/detail/named_table.h"
#include "mrpt_plugins/import/log_writer.h"
#include "mrpt_plugins/input/odometry_gap.h"
#include "mrpt_plugins/input/odometry_reset.h"

namespace hybrid {

/// Names of columns that others use.
inline const ColumnAliases kColumnAliases{
    {"t", "time"},      {"timestamp", "time"}, {"stamp", "time"},        {"distance", "range"},
    {"dist", "range"},  {"r", "range"},        {"bearing", "yaw"},       {"theta", "yaw"},
    {"heading", "yaw"}, {"angle", "yaw"},      {"azimuth", "yaw"},       {"elevation", "pitch"},
    {"label", "class"}, {"category", "class"}, {"name", "class"},        {"confidence", "score"},
    {"conf", "score"},  {"prob", "score"},     {"probability", "score"}, {"beacon", "id"},
    {"anchor", "id"},   {"tag", "id"},         {"tag_id", "id"},         {"marker", "id"},
    {"marker_id", "id"}};

/// A motion by odometry that wanders by so much [m, rad] per square root of a metre of way.
OdometryIncrement wandering_motion(const mrpt::poses::CPose3D& from, const mrpt::poses::CPose3D& to,
                                   bool is_3d, double walk_translation, double walk_rotation);

/// The pose at a time between two others, of which the second is later.
mrpt::poses::CPose3D pose_between(const TimedPose& before, const TimedPose& after, double time);

/// The odometry, interpolated at times that do not fall. Where several poses have one time stamp,
/// the first ends the motion before it and the last begins that after it.
class TableOdometry {
 public:
  explicit TableOdometry(const std::string& path);

  /// Sets what is called with every row that at() and finish() pass.
  void watch(std::function<void(const TimedPose&)> watcher) { watcher_ = std::move(watcher); }

  bool is_3d() const { return is_3d_; }
  /// Time of the first pose; 0 if there is none.
  double start() const { return start_; }

  /// Length of the path up to the last pose read [m], and its time [s].
  double way() const { return way_; }
  double end() const { return end_; }

  /// How often it had started anew before the last pose that at() gave: poses before and after are
  /// not in one frame.
  std::size_t resets() const { return frame_; }

  /// Reads what is left, so that a fault there is told as well, and notes what is odd about it.
  void finish(LogWriter& log);

  /// The pose at `time`; empty before the first pose and after the last one, where it starts anew,
  /// and where poses are missing while it moves.
  std::optional<mrpt::poses::CPose3D> at(double time);

 private:
  void advance();
  void pass();
  void read_row();
  void note_place(const mrpt::poses::CPose3D& pose);

  std::string path_;
  std::function<void(const TimedPose&)> watcher_;
  std::optional<NamedTable> table_;
  std::vector<TimedPose> poses_;  // of a file with quaternions
  OdometryReset reset_;
  bool is_new_ = false;   // whether it starts anew at `after_`
  bool has_gap_ = false;  // poses are missing between `before_` and `after_`
  OdometryGap gap_;
  std::size_t resets_ = 0, frame_ = 0, repeated_ = 0, gaps_ = 0;
  std::size_t read_ = 0;  // poses of `poses_` used so far
  bool is_3d_ = false;
  double start_ = 0, end_ = 0, way_ = 0;
  std::optional<double> yaw_;  // in the last row
  std::optional<TimedPose> before_, after_;
};

}  // namespace hybrid
