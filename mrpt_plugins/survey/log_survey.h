// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <string>
#include <vector>

#include "libhybrid/uncertainty/sensor_alignment.h"
#include "libhybrid/uncertainty/sensor_noise.h"
#include "mrpt_plugins/input/log_contents.h"

namespace HYBRID_API hybrid {

/// Measures noise, clocks and mountings of a log, without a map: see measure_sensor_noise and
/// estimate_sensor_alignment. Of each sensor it keeps up to 20,000 frames with detections, in
/// stretches that are evenly spread over the log.
class LogSurvey {
 public:
  /// `aligns`: mountings and clocks are measured too, which those who calibrate them do otherwise.
  explicit LogSurvey(const SourceOptions& options, bool aligns = true)
      : options_(options), aligns_(aligns) {}

  /// The next step of the log and the detections in it.
  void add(const LogStep& step, const std::vector<DetectionFrame>& frames);

  /// What was found, and what of it is to be used: what the log tells well enough, and the options
  /// do not give.
  LogFindings conclude() const;
  /// The same of ids alone: all that is used of a log that is taken at its word.
  LogFindings conclude_ids() const;
  /// The sensors whose sign or unit is not as stated; nothing is corrected.
  std::vector<AlignmentRecord> contradictions() const;

 private:
  struct Sensor {
    std::vector<MovedSightings> frames;
    OdometryIncrement since;  ///< motion since the last of them
    bool directions_only = false;
    std::size_t seen = 0;   ///< frames, kept or not
    std::size_t every = 1;  ///< of so many stretches one is kept
  };

  void keep(MovedSightings seen, Sensor& sensor) const;
  MovedSightings moved(const DetectionFrame& frame, double time, const Sensor& sensor) const;
  AlignmentRecord align(const std::string& label, const Sensor& sensor) const;
  SensorNoise noise_of(Sensor sensor, const SensorCorrection& correction) const;
  SensorNoise measure(const std::string& label, const Sensor& sensor, LogFindings& out) const;
  void use(const std::string& label, const SensorNoise& found, LogFindings& out) const;
  void use_odometry(const std::vector<SensorNoise>& noise, LogFindings& out) const;
  void check_ids(LogFindings& out) const;

  SourceOptions options_;
  bool aligns_;
  std::vector<OdometryPose> path_;
  int chain_ = 0;
  std::map<std::string, Sensor> sensors_;
};

/// Reads a log and measures it.
LogFindings survey_log(const std::string& rawlog, const SourceOptions& options, bool aligns = true);

}  // namespace hybrid
