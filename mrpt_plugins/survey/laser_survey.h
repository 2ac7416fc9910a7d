// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/scans/laser_mounting.h"
#include "mrpt_plugins/input/log_correction.h"
#include "mrpt_plugins/input/rawlog_reader.h"
#include "mrpt_plugins/input/scans.h"

namespace HYBRID_API hybrid {

/// Field of view, sense of rotation and place of each laser, measured on the first part of a log
/// where the robot moves (see measure_mounting).
class LaserSurvey {
 public:
  explicit LaserSurvey(const ScanOptions& options) : options_(options) {}

  void add(const LogStep& step);
  /// Adds what is to be used in place of what the log states, and says so.
  void conclude(LogFindings& findings) const;

 private:
  struct Laser {
    std::vector<MovedScan> scans;
    std::optional<SE2> since;  ///< motion by odometry since the last of them
  };
  void take(const std::string& label, LaserScan scan);

  ScanOptions options_;
  std::map<std::string, Laser> lasers_;
};

}  // namespace hybrid
