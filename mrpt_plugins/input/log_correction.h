// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "libhybrid/detections/detection.h"
#include "libhybrid/fixes/fix.h"
#include "libhybrid/fixes/receiver_fit.h"
#include "libhybrid/scans/laser_mounting.h"
#include "libhybrid/uncertainty/sensor_delay.h"
#include "mrpt_plugins/input/odometry.h"

namespace HYBRID_API hybrid {

/// The noise of ranges or angles of a sensor, where it is not that of the log.
struct NoiseModel {
  bool is_scaled = false;  ///< `factor` times what the log states, or by range
  double factor = 1;
  /// The sigma of a range r is hypot(constant, by_range r), of angles hypot(constant, by_range /
  /// r).
  double constant = 0, by_range = 0;
};

/// What was found out about a sensor.
struct SensorCorrection {
  double length = 1;      ///< its ranges are multiplied by, for they have another unit
  bool mirrored = false;  ///< its bearings have the other sign
  double yaw = 0;         ///< it is turned by, beside what the log says [rad]
  double delay = 0;       ///< it is behind the odometry [s]
  std::optional<NoiseModel> range, angle;

  bool is_none() const {
    return length == 1 && !mirrored && yaw == 0 && delay == 0 && !range && !angle;
  }
};

/// What was found out about a receiver of satellites.
struct ReceiverCorrection {
  std::shared_ptr<const FixModel> model;
  double sigma_factor = 1;  ///< of what its fixes state
  double delay = 0;         ///< its stamps are late by [s]
};

/// What was found out about a log, in place of what it states.
struct LogCorrection {
  std::map<std::string, SensorCorrection> sensors;  ///< by label
  std::map<std::string, LaserMounting> lasers;      ///< the same of those that scan
  std::map<std::string, ReceiverCorrection> receivers;
  double translation = 1, rotation = 1;  ///< factors of the standard deviations of odometry
  bool hides_ids = false;                ///< ids are of a tracker
  std::set<std::int64_t> shared_ids;     ///< ids of two things each, which are hidden
  /// By odometry, where a sensor is delayed.
  std::shared_ptr<const std::vector<OdometryPose>> path;

  /// Corrects what a sensor saw at a time of the log, before anything else uses it.
  void correct(double time, DetectionFrame& frame) const;
  void correct(OdometryIncrement& odometry) const;
  void correct(const std::string& label, LaserScan& scan) const;
  void correct(Fix& fix) const;

  /// Whether the log is taken at its word.
  bool is_none() const;
};

/// One kind of noise: what the log states, what was measured, what is used.
struct NoiseRecord {
  std::string sensor;            ///< its label, or "odometry"
  std::string kind;              ///< range, angle, translation, rotation
  std::string unit;              ///< m or rad; empty for factors of what is stated
  double at_range = 0;           ///< where that depends on the range [m]
  std::optional<double> stated;  ///< nothing where there is nothing to measure
  std::optional<double> measured, sigma;
  double used = 0;
  std::string model;  ///< how what is used depends on the range; empty: as the log states
  std::string why;    ///< nothing was measured that can be used; empty where it was
  std::vector<std::pair<double, double>> growth;  ///< of errors over a time [s], by a factor
};

/// Clock and mounting of one sensor.
struct AlignmentRecord {
  std::string sensor;
  double length = 1;  ///< see SensorAlignment
  bool mirrored = false;
  double mirror_sigmas = 0, yaw = 0, yaw_sigma = 0, delay = 0, delay_sigma = 0;  ///< [rad], [s]
  std::string unknown;  ///< what the log cannot tell; empty if it tells all
};

/// What was measured of a log before it was mapped.
struct LogFindings {
  LogCorrection correction;
  std::vector<NoiseRecord> noise;
  std::vector<AlignmentRecord> alignment;
  /// Of receivers of satellites by label, which are still to be measured.
  std::map<std::string, std::vector<MovedFix>> fixes;
  std::vector<std::string> remarks;  ///< what differs from what is stated, for the user
};

}  // namespace hybrid
