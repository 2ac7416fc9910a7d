// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/core/key.h"
#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Detections from which on a tracklet tells how its thing moves.
inline constexpr std::size_t kFewestForMotion = 3;

/// One sighting of a thing, which is at from_polar(range, yaw, pitch) in the frame of the sensor:
/// positive pitch points down.
struct Detection {
  double range = 0, yaw = 0, pitch = 0;  ///< [m], [rad]; pitch is 0 for a planar sensor.
  std::optional<std::int64_t> id;        ///< Landmark, if the sensor identifies it.
  std::optional<std::int64_t> true_id;   ///< For evaluation only; `id` where the log has no other.
  std::vector<double> class_probabilities;  ///< Sums to 1, as long as class_names; or empty.
  /// Of (range, yaw, pitch); the row and column of pitch are zero for a planar sensor.
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  bool moving = false;  ///< Its thing moves, as far as is known.
  bool at_rest = true;  ///< Whether its members fit one thing at rest.
  double delay = 0;     ///< Time of the detection after that of its frame [s].
  /// How its thing moves, seen from the sensor as it stands at the time of the frame [m/s].
  struct Velocity {
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  };
  std::optional<Velocity> velocity = std::nullopt;  ///< Where it was measured.
  /// The true ids of the detections that this one stands for; empty where it is a single one.
  std::vector<std::optional<std::int64_t>> members = {};

  /// Whether it may be the sighting of a landmark: nothing says that its thing moves.
  bool may_be_landmark() const { return at_rest && !moving; }
};

/// What one sensor saw at one time.
struct DetectionFrame {
  double time = 0;  ///< Of the observation [s since 1970]; 0 if it has none.
  std::string sensor_label;
  Eigen::Isometry3d T_robot_sensor = Eigen::Isometry3d::Identity();
  std::optional<Key> calibrated;  ///< The variable that is T_robot_sensor, where it is estimated.
  bool is_3d = true;
  bool has_range = true;  ///< False for a sensor of directions only: all ranges are 0.
  double min_range = 0, max_range = 0;  ///< [m], 0: no limit.
  double fov_yaw = 0, fov_pitch = 0;    ///< Full angles [rad].
  std::vector<std::string> class_names;
  std::vector<Detection> detections;
};

}  // namespace hybrid
