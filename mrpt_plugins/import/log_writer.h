// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/io/file_writer.h"
#include "mrpt_plugins/bridge/log_files.h"
#include "mrpt_plugins/import/detector_noise.h"
#include "mrpt_plugins/input/odometry.h"
#include "mrpt_plugins/input/rawlog_reader.h"
#include "mrpt_plugins/observations/classed_bearing_range.h"

namespace HYBRID_API hybrid {

/// One step of the robot for a rawlog.
struct ImportedStep {
  double time = 0;                          ///< [s], since 1970 or any other start.
  std::optional<OdometryIncrement> motion;  ///< Since the last step; empty at the first one.
  std::vector<mrpt::obs::CObservation::Ptr> observations;  ///< Their timestamps are set to the time
                                                           ///< of the step.
  std::optional<mrpt::poses::CPose3D> truth;  ///< True pose; for all steps of a log or for none.
  /// Seen since the last step: they follow in the frame and keep their own timestamps.
  std::vector<mrpt::obs::CObservation::Ptr> stamped = {};
};

/// What an import wrote and dropped.
struct ImportReport {
  std::vector<std::string> files;  ///< Files written, the rawlog first.
  std::size_t steps = 0, observations = 0, detections = 0, landmarks = 0;
  double duration = 0;             ///< From first to last step [s].
  DropReport dropped;              ///< Reason -> count.
  std::vector<std::string> notes;  ///< Other remarks for the user.
};

/// Writes F.rawlog as actions and sensory frames, step by step, and the ground truth beside it:
/// F_ground_truth_robot_path.txt (one row per step), F_ground_truth.txt (landmarks, class last),
/// F_ground_truth_robot_path.xyz (timed positions, where orientations are unknown) and
/// F_ground_truth_associations.csv and F_ground_truth_movers.csv; F_ids.csv, the names that ids
/// stand for; and F_held_out_fixes.xyz. finish() makes all of them appear together. Throws Error
/// that names the file on write errors.
class LogWriter {
 public:
  /// `path` is F.rawlog; its folder is created if absent.
  explicit LogWriter(const std::string& path);

  /// Throws Error if time decreases or if only some steps have a true pose; Interrupted if the
  /// program was asked to stop.
  void add(const ImportedStep& step);

  /// Adds a reading of the odometry [s] between steps, for the path between them. A step that has
  /// one of its own time, before it or behind it, ties them to the path.
  void add_odometry(double time, const mrpt::poses::CPose3D& pose, bool is_3d);

  /// Counts something dropped.
  void drop(const std::string& reason, std::size_t count = 1) { report_.dropped[reason] += count; }

  /// Tells how much of the input the next step has used, 0 to 1, for a progress display.
  void used(double share) { share_ = share; }

  /// Adds a remark for the user.
  void note(const std::string& text) { report_.notes.push_back(text); }
  /// Adds a remark if the last line of an input file has no newline: a number in it may be cut off.
  /// Of a folder, if that is so for some of its .txt files; where it is for all, their writer makes
  /// none.
  void note_end(const std::string& input);

  /// A true landmark; an empty class name means it has none.
  void true_landmark(std::int64_t id, const Eigen::Vector3d& position,
                     const std::string& class_name = {});

  /// A true position of the robot without orientation; times must not decrease.
  void true_position(double time, const Eigen::Vector3d& position);

  /// A satellite fix that is not in the log, so that it can judge: position of the antenna [m].
  void held_out_fix(double time, const Eigen::Vector3d& position);

  /// True landmark id of measurement `index` of the step that is added next.
  void true_association(std::size_t index, std::int64_t true_id);

  /// A true position [m], in the frame of the true path, of a thing that moves, at the step that is
  /// added next.
  void true_mover(std::int64_t true_id, const Eigen::Vector3d& position);

  /// The name that the sensor gives to what the log numbers.
  void name_of(std::int64_t id, const std::string& name);

  /// Steps added so far.
  std::size_t steps() const { return report_.steps; }

  /// Closes, checks and renames all files. Call it last.
  ImportReport finish();

 private:
  void note_ends(const std::string& folder);
  void write_position(std::string_view suffix, double time, const Eigen::Vector3d& position);
  FileWriter& side_file(std::string_view suffix, const std::string& header);

  LogFiles files_;
  std::map<std::string_view, FileWriter> side_files_;  // by suffix
  ImportReport report_;
  double first_time_ = 0, last_time_ = 0;
  double share_ = 0;  // of the input that has been used
  bool has_truth_ = false;
};

/// How far an import has come.
struct ImportProgress {
  std::size_t steps = 0;  ///< written so far
  double seconds = 0;     ///< from the first of them to the last
  double share = 0;       ///< of the input that has been used, 0 to 1
};

/// Sets a function that is called at every step written by this process, for a progress display.
/// Empty: none.
void watch_steps(std::function<void(const ImportProgress&)> watcher);

/// An empty frame of a planar detector, with its noise at close range and its pose on the robot.
CObservationClassedBearingRange::Ptr planar_detections(const std::string& label,
                                                       const DetectorNoise& noise,
                                                       const mrpt::poses::CPose3D& T_robot_sensor);

/// A motion in the plane with its tangent covariance over (x, y, angle).
OdometryIncrement planar_motion(double x, double y, double angle,
                                const Eigen::Matrix3d& covariance);

}  // namespace hybrid
