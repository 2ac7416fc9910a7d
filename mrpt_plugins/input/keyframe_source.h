// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/detections/detection_tracker.h"
#include "mrpt_plugins/bridge/ini_file.h"
#include "mrpt_plugins/input/detections.h"
#include "mrpt_plugins/input/fixes.h"
#include "mrpt_plugins/input/keyframe_policy.h"
#include "mrpt_plugins/input/log_correction.h"
#include "mrpt_plugins/input/rawlog_reader.h"
#include "mrpt_plugins/input/repeated_detections.h"
#include "mrpt_plugins/input/scan_watch.h"
#include "mrpt_plugins/input/scans.h"

namespace HYBRID_API hybrid {

/// A pose of the robot that becomes a variable of the map, with its measurements.
struct Keyframe {
  std::size_t robot = 0;  ///< whose, where there are several
  std::size_t row = 0;    ///< step of the log, which is the row of MRPT's ground truth of the path
  double time = 0;        ///< s
  std::optional<OdometryIncrement> odometry;  ///< motion since the keyframe before
  /// Where odometry says that the robot was since the keyframe before, seen from this one.
  std::vector<PoseBetween> between;
  std::vector<DetectionFrame> detections;
  std::vector<DetectionFrame> robots;  ///< detections of robots (DetectionOptions::robots)
  std::vector<mrpt::obs::CObservation::Ptr> observations;  ///< see Frame of a mapping plugin
  /// Laser scans since the keyframe before, in order of time, those of the keyframe itself last;
  /// each tells where the robot was.
  std::vector<LaserScan> scans;
  std::vector<LoggedFix> fixes;  ///< of satellite receivers, since the keyframe before
};

enum class Dimension { kAuto, kPlane, kSpace };

/// Where noise, clock and mounting of sensors come from.
enum class NoiseSource {
  kAuto,     ///< as stated; measured where the map then says of itself that it is wrong
  kStated,   ///< the log is taken at its word
  kMeasured  ///< from the log, before it is mapped
};

struct SourceOptions {
  RawlogOptions reader;
  KeyframeOptions keyframes;
  bool tracklets = false;  ///< use detections between keyframes as tracklets; else they are left
                           ///< out
  bool has_keyframe_distance = false;  ///< this, or a time, is given; it may be 0
  bool has_keyframe_angle = false;     ///< the same
  DetectionTrackerOptions tracker;
  DetectionOptions detections;
  ScanOptions scans;
  /// Keyframes are those of scans: the last step becomes one, so that the scans since the one
  /// before are not lost, and a step where scans tell of motion of which odometry does not.
  bool follows_scans = false;
  Dimension dimension = Dimension::kAuto;
  NoiseSource noise = NoiseSource::kStated;
  LogCorrection correction = {};
  std::size_t steps = 0;  ///< of the log, to tell how much of it is read; 0: not known
};

/// Reads sections [map], [keyframes], [sensor] and [reader].
SourceOptions read_source_options(IniFile& ini);

/// A rawlog as a stream of keyframes.
class KeyframeSource {
 public:
  /// Throws Error if the file is missing or cannot be opened.
  KeyframeSource(const std::string& rawlog, const SourceOptions& options);

  /// Nothing at the end of the log. Throws Interrupted where a signal comes while standard input
  /// keeps it waiting.
  std::optional<Keyframe> next();

  /// At the end of the log: where odometry says that the robot was since the last keyframe, seen
  /// from it.
  std::vector<PoseBetween> rest() const;

  /// Whether the map is 3-D. Unless set by the options, it is if odometry or a sensor (tilted, or
  /// measuring pitch, or seeing clouds) is 3-D in more than half of the first 100 keyframes that
  /// have it. A single damaged entry therefore does not decide; plugins drop and count what does
  /// not fit the map.
  bool is_3d();

  LogStatus status() const { return reader_.status(); }
  /// Why the log ended early; empty if complete.
  const std::string& message() const { return reader_.message(); }
  /// Share of the log up to the newest keyframe: of its steps, or of its bytes, which are read
  /// ahead, where their number is not known; nothing where standard input does not tell it.
  std::optional<double> progress() const { return progress_; }
  /// Measurements dropped or repaired, by reason.
  const DropReport& dropped() const { return dropped_; }
  /// Observations read so far by class, without namespace, used or not.
  const std::map<std::string, std::size_t>& observations() const { return reader_.observations(); }
  /// Problems in the log that were handled, by kind.
  DropReport warnings() const;
  double repeated_stamps() const { return reader_.repeated_stamps(); }
  std::size_t odometry_stops() const { return reader_.odometry_stops(); }

 private:
  std::optional<LogStep> next_step();
  std::optional<Keyframe> read();
  std::optional<double> share_read() const;
  void track(const LogStep& step, bool is_keyframe, std::vector<DetectionFrame>& detections);
  void collect_scans(const LogStep& step);
  void collect_fixes(const LogStep& step);
  void collect_poses(const LogStep& step);
  bool makes_keyframe(const LogStep& step);
  Keyframe make_keyframe(LogStep& step, Keyframe keyframe);

  SourceOptions options_;
  RawlogReader reader_;
  KeyframePolicy policy_;
  DetectionTracker tracker_;
  RepeatedDetections repeated_;
  ScanCollector scans_;
  FixCollector fixes_;
  PosesBetween between_;
  Eigen::Isometry3d T_start_step_ = Eigen::Isometry3d::Identity();  // by odometry
  ScanWatch watch_;
  std::size_t steps_read_ = 0;
  std::size_t halved_scans_ = 0;     // see is_halved_scan()
  std::optional<LogStep> skipped_;   // the last step, where it is no keyframe and may become one
  std::optional<LogStep> put_back_;  // the step behind a skipped one that became a keyframe
  DropReport dropped_;
  struct Ahead {
    Keyframe keyframe;
    std::optional<double> progress;  ///< of the reader behind it
  };
  std::deque<Ahead> ahead_;
  std::optional<double> progress_ = 0;
};

}  // namespace hybrid
