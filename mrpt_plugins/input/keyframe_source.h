// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/landmarks/detection_tracker.h"
#include "mrpt_plugins/bridge/ini_file.h"
#include "mrpt_plugins/input/detections.h"
#include "mrpt_plugins/input/keyframe_policy.h"
#include "mrpt_plugins/input/rawlog_reader.h"

namespace HYBRID_API hybrid {

/// A place of the robot that becomes a pose of the map.
struct Keyframe {
  std::size_t row = 0;  ///< step of the log, which is the row of MRPT's ground truth of the path
  double time = 0;      ///< s
  std::optional<OdometryIncrement> odometry;  ///< motion since the keyframe before
  std::vector<DetectionFrame> detections;
  std::vector<mrpt::obs::CObservation::Ptr> observations;  ///< see Frame of a mapping plugin
};

enum class Dimension { kAuto, kPlane, kSpace };

struct SourceOptions {
  RawlogOptions reader;
  KeyframeOptions keyframes;
  bool tracklets = false;  ///< of detections between keyframes; these are left out otherwise
  DetectionTrackerOptions tracker;
  DetectionOptions detections;
  Dimension dimension = Dimension::kAuto;
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

  /// Whether the map must be in space, unless chosen: odometry is of space, or a sensor is tilted
  /// or measures pitch, each in more than half of the first 100 keyframes where it says something.
  /// So no single damaged entry decides; plugins leave out, and count, what does not fit the map.
  bool is_3d();

  LogStatus status() const { return reader_.status(); }
  /// How the log ended; empty if complete.
  const std::string& message() const { return reader_.message(); }
  /// Share of the log up to the newest keyframe; nothing where standard input does not tell it.
  std::optional<double> progress() const { return progress_; }
  /// Measurements dropped or repaired, by reason.
  const DropReport& dropped() const { return dropped_; }
  /// Observations read so far by class, without namespace, used or not.
  const std::map<std::string, std::size_t>& observations() const { return reader_.observations(); }
  /// Odd things in the log that were got over, by kind.
  DropReport warnings() const { return reader_.warnings(); }

 private:
  std::optional<Keyframe> read();
  void track(const LogStep& step, bool is_keyframe, std::vector<DetectionFrame>& detections);

  SourceOptions options_;
  RawlogReader reader_;
  KeyframePolicy policy_;
  DetectionTracker tracker_;
  DropReport dropped_;
  struct Ahead {
    Keyframe keyframe;
    std::optional<double> progress;  ///< of the reader behind it
  };
  std::deque<Ahead> ahead_;
  std::optional<double> progress_ = 0;
};

}  // namespace hybrid
