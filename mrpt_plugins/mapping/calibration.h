// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/core/key_letters.h"
#include "mrpt_plugins/bridge/ini_file.h"
#include "mrpt_plugins/input/detections.h"
#include "mrpt_plugins/input/odometry.h"
#include "mrpt_plugins/mapping/backend.h"
#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// Which parameters of the robot are estimated, with start values and priors.
struct CalibrationOptions {
  bool sensor_pose = false;
  std::optional<mrpt::poses::CPose3D> sensor_start;  ///< none: that of the log
  double sensor_sigma_m = 1.0;
  double sensor_sigma_rad = 1.0;
  bool odometry = false;
  /// Scale of translation, scale of rotation, drift [rad/m]: one number, or three in 3-D.
  std::vector<double> odometry_start;
  double scale_sigma = 0.5;
  double drift_sigma = 0.5;  ///< rad/m
};

/// Whether a variable is a calibration of a sensor or of the odometry.
inline bool is_calibration(Key key) {
  return key.letter() == key_letter::kSensorPose ||
         key.letter() == key_letter::kOdometryCalibration;
}

/// Reads section [calibration].
CalibrationOptions read_calibration_options(IniFile& ini);

/// Calibration parameters of a robot as variables of the map: one pose per sensor, by label, and
/// one for the odometry. Each enters the graph with its prior when it is first used.
class Calibrator {
 public:
  /// Throws Error where the options do not fit a map of this dimension. `robot` is the name, empty
  /// where there is but one, and `number` which of several it is.
  Calibrator(const CalibrationOptions& options, bool is_3d, std::string robot = {},
             std::size_t number = 0);

  /// Sets the sensor poses of `frames` to their estimates in `values`, and the keys of their
  /// variables. Adds new variables and their priors to `delta`.
  void place_sensors(std::vector<DetectionFrame>& frames, const Values& values, Delta& delta);

  /// Where a sensor sits by its estimate in `values`; nothing if it is not calibrated.
  std::optional<Eigen::Isometry3d> sensor(const std::string& label, const Values& values) const;

  /// The variable of the odometry, or nothing if it is not calibrated. If `values` lacks it, it is
  /// added to `delta` with its prior.
  std::optional<Key> odometry(const Values& values, Delta& delta) const;
  /// The motion corrected by the present estimate.
  mrpt::poses::CPose3D corrected(const mrpt::poses::CPose3D& motion, const Values& values) const;

  /// Estimates, and which of them are observed: by comparing the marginal covariance with that of
  /// the prior.
  std::vector<CalibrationEstimate> estimates(const Backend& backend) const;

 private:
  struct Sensor {
    Key key;
    mrpt::poses::CPose3D start, logged;
  };

  void add_sensor(const Sensor& sensor, Delta& delta) const;
  CalibrationEstimate sensor_estimate(const std::string& label, const Sensor& sensor,
                                      const Backend& backend) const;
  CalibrationEstimate odometry_estimate(const Backend& backend) const;

  Key key(char letter, std::size_t index) const;
  std::string named(const std::string& what) const;

  CalibrationOptions options_;
  bool is_3d_;
  std::string robot_;
  std::size_t number_;
  Key odometry_;
  std::map<std::string, Sensor> sensors_;  // that were seen; their variables may not be in the map
};

}  // namespace hybrid
