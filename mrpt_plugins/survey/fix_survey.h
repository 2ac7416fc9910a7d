// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <string>
#include <vector>

#include "libhybrid/fixes/receiver_fit.h"
#include "mrpt_plugins/input/fixes.h"
#include "mrpt_plugins/input/log_correction.h"

namespace HYBRID_API hybrid {

/// Collects the fixes of a log with the motion by odometry between them.
class FixSurvey {
 public:
  /// `clock_offset` is added to the stamps of fixes, as to those of the steps [s].
  explicit FixSurvey(double clock_offset = 0) : clock_offset_(clock_offset) {}

  void add(const LogStep& step);
  /// Hands over what was collected, by the label of the receiver.
  std::map<std::string, std::vector<MovedFix>> release();

 private:
  struct Track {
    std::vector<MovedFix> fixes;
    OdometryIncrement since;  // the last fix
    bool is_broken = true;    // that motion is not known
  };
  void take(const LoggedFix& fix, double early);

  double clock_offset_;
  DatumFinder datum_;
  RepeatedFixes repeats_;
  std::map<std::string, Track> tracks_;  // by label
  DropReport dropped_;                   // of which the mapping tells
  Eigen::Vector2d velocity_ = Eigen::Vector2d::Zero();
  double time_ = 0;
};

/// Measures noise and clock of the receivers whose fixes are in `findings`, which it says there,
/// and of the odometry by the one with most fixes, where `tells_odometry`: no other sensor tells
/// it. Adds to the correction what is to be used in place of what is stated.
void measure_fixes(const FixModel& prior, bool tells_odometry, LogFindings& findings,
                   LogCorrection& correction);

}  // namespace hybrid
