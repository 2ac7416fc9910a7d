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

/// One place of the robot on its way into a rawlog.
struct ImportedStep {
  double time = 0;                          ///< [s since 1970], or since any start.
  std::optional<OdometryIncrement> motion;  ///< Since the step before; left out of the first step.
  std::vector<mrpt::obs::CObservation::Ptr> observations;  ///< Get the time of the step.
  std::optional<mrpt::poses::CPose3D> truth;  ///< True pose; for all steps of a log or for none.
};

/// What an import made and what it left out.
struct ImportReport {
  std::vector<std::string> files;  ///< Written, the rawlog first.
  std::size_t steps = 0, observations = 0, detections = 0, landmarks = 0;
  double duration = 0;             ///< From first to last step [s].
  DropReport dropped;              ///< Reason -> count.
  std::vector<std::string> notes;  ///< What else is worth knowing.
};

/// Writes F.rawlog as actions and sensory frames, step by step, and what is true beside it:
/// F_ground_truth_robot_path.txt (a row per step), F_ground_truth.txt (landmarks, class last),
/// F_ground_truth_robot_path.xyz (positions in time, where no more is known) and
/// F_ground_truth_associations.csv. All appear together in finish(), or not at all. Throws Error
/// that names the file where writing fails.
class LogWriter {
 public:
  /// `path` is F.rawlog; its folder is created if absent.
  explicit LogWriter(const std::string& path);

  /// Throws Error for time going backwards, and for truth at some steps only; Interrupted where
  /// the program was asked to stop.
  void add(const ImportedStep& step);

  /// Counts something that was not taken over.
  void drop(const std::string& reason, std::size_t count = 1) { report_.dropped[reason] += count; }

  /// Something to be told.
  void note(const std::string& text) { report_.notes.push_back(text); }
  /// Notes it where the last line of a file that was read has no end: a number in it may be cut.
  void note_end(const std::string& input);

  /// A true landmark; an empty class name means it has none.
  void true_landmark(std::int64_t id, const Eigen::Vector3d& position,
                     const std::string& class_name = {});

  /// A true position of the robot without orientation, times rising.
  void true_position(double time, const Eigen::Vector3d& position);

  /// What measurement `index` of the step to be added next really saw.
  void true_association(std::size_t index, std::int64_t true_id);

  /// Steps added so far.
  std::size_t steps() const { return report_.steps; }

  /// Closes, checks and renames all files. Nothing can be added afterwards.
  ImportReport finish();

 private:
  FileWriter& side_file(std::string_view suffix, const std::string& header);

  LogFiles files_;
  std::map<std::string_view, FileWriter> side_files_;  // by suffix
  ImportReport report_;
  double first_time_ = 0, last_time_ = 0;
  bool has_truth_ = false;
};

/// Tells `watcher` of every step that is written from now on by this process: how many there are,
/// and the time of the log so far [s]. For a line of progress; empty: nobody is told.
void watch_steps(std::function<void(std::size_t steps, double seconds)> watcher);

/// A frame of a planar detector: its noise close by, place on the robot.
CObservationClassedBearingRange::Ptr planar_detections(const std::string& label,
                                                       const DetectorNoise& noise,
                                                       const mrpt::poses::CPose3D& T_robot_sensor);

/// A motion in the plane with its tangent covariance over (x, y, angle).
OdometryIncrement planar_motion(double x, double y, double angle,
                                const Eigen::Matrix3d& covariance);

}  // namespace hybrid
