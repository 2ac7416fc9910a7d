// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CObservation.h>
#include <mrpt/poses/CPose3D.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/core/key.h"
#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/input/rawlog_reader.h"

namespace HYBRID_API hybrid {

/// One sighting of a landmark. The point lies at CPose3D(0, 0, 0, yaw, pitch, 0) * (range, 0, 0) in
/// the frame of the sensor: positive pitch points down.
struct Detection {
  double range = 0, yaw = 0, pitch = 0;  ///< [m], [rad]; pitch is 0 for a planar sensor.
  std::optional<std::int64_t> id;        ///< Landmark, if the sensor identifies it.
  std::optional<std::int64_t> true_id;   ///< For evaluation only; `id` where the log has no other.
  std::vector<double> class_probabilities;  ///< Sums to 1, as long as class_names; or empty.
  /// Of (range, yaw, pitch); the row and column of pitch are zero for a planar sensor.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  bool moving = false;  ///< Followed for a while, it was not at rest: no landmark.
  /// The true ids of the detections that this one stands for; empty where it is a single one.
  std::vector<std::optional<std::int64_t>> members = {};
};

/// What one sensor saw at one time, whichever MRPT class it came in.
struct DetectionFrame {
  double time = 0;  ///< Of the observation [s since 1970]; 0 if it has none.
  std::string sensor_label;
  mrpt::poses::CPose3D T_robot_sensor;
  std::optional<Key> calibrated;  ///< The variable that is T_robot_sensor, where it is estimated.
  bool is_3d = true;
  bool has_range = true;  ///< False for a sensor of directions only: all ranges are 0.
  double min_range = 0, max_range = 0;  ///< [m], 0: no limit.
  double fov_yaw = 0, fov_pitch = 0;    ///< Full angles [rad].
  std::vector<std::string> class_names;
  std::vector<Detection> detections;
};

/// Which landmark ids a mapper gets to see.
enum class IdSource {
  kLog,    ///< Those of the sensor.
  kNone,   ///< None: they are only kept as truth, for evaluation.
  kTruth,  ///< The true ones, where the log has them: an association that is never wrong.
};

/// What is accepted as a measurement, and which noise it is given.
struct DetectionOptions {
  IdSource ids = IdSource::kLog;
  double max_range = 1000.0;  ///< Ranges beyond are dropped [m].
  /// Used in place of the sigmas of the log, where positive [m], [rad].
  double sigma_range = 0, sigma_yaw = 0, sigma_pitch = 0;
  /// Used where neither the above nor the log gives a positive, finite sigma [m], [rad].
  double default_sigma_range = 0.1, default_sigma_angle = 0.02;
  /// Class probabilities are divided by their sum if it is further than this from 1.
  double sum_tolerance = 1e-3;
};

/// The detections in a CObservationBearingRange or a CObservationClassedBearingRange; nothing for
/// other classes. A bearing-range observation is planar if it claims no uncertainty in pitch and
/// all its pitches are zero.
///
/// Dropped, each counted in `report` by reason: detections with range, yaw or pitch not finite;
/// range not positive, above the limit or above that of the sensor; outside the field of view, such
/// as behind the sensor; |yaw| above 2 pi or |pitch| above pi/2; a sigma above the limit of range
/// or half a turn; an id seen before in the same observation; a covariance that is not positive
/// definite; whole observations whose sensor pose is not finite, no rigid motion, or farther from
/// the robot than the limit of range.
/// Repaired and counted: class scores of a wrong length, negative, not finite or all zero are
/// removed (the detection counts as not classified); other sums are normalised; sigmas that are
/// missing or below 1e-6 are replaced by the defaults; ids below -1 are taken as none.
std::optional<DetectionFrame> detections_in(const mrpt::obs::CObservation& observation,
                                            const DetectionOptions& options, DropReport& report);

}  // namespace hybrid
