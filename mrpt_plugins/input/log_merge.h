// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/input/keyframe_source.h"

namespace HYBRID_API hybrid {

/// The logs of several robots, or of one, as one stream of keyframes in the order of time; of those
/// of one time, the robot that was added first goes first.
class LogMerge {
 public:
  /// Adds the log of the next robot; `name` is for messages, and may be empty where there is but
  /// one. Throws Error if the file is missing or cannot be opened.
  void add(const std::string& name, const std::string& rawlog, const SourceOptions& options);

  /// Whether there is a keyframe; `next` gives it.
  bool begins();
  /// The next keyframe, with the number of its robot.
  std::optional<Keyframe> next();

  /// Where odometry says that a robot was since its last keyframe, seen from it; nothing before the
  /// end of its log.
  std::vector<PoseBetween> rest(std::size_t robot) const;

  /// Whether the map must be in space (see KeyframeSource). Throws Error where the logs disagree.
  bool is_3d();

  /// How the logs ended: the first that did not end well.
  LogStatus status() const;
  const std::string& message() const;
  /// Share of the logs up to the newest keyframes, where the length of all of them is known.
  std::optional<double> progress() const;
  DropReport dropped() const;
  std::map<std::string, std::size_t> observations() const;
  DropReport warnings() const;
  /// That of the worst log, see RawlogReader.
  double repeated_stamps() const;
  /// Of all logs, see RawlogReader.
  std::size_t odometry_stops() const;

 private:
  struct Log {
    std::string name;
    std::unique_ptr<KeyframeSource> source;
    std::optional<Keyframe> ahead;
    bool ended = false;
  };
  const KeyframeSource& worst() const;

  std::vector<Log> logs_;
};

}  // namespace hybrid
