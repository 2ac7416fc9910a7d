// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "libhybrid/core/key.h"
#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

struct FixModel;

/// A measured position of an antenna on the robot, as satellite receivers give it.
struct Fix {
  std::string sensor;  ///< label of the receiver: a robot may have several
  double time = 0;     ///< [s]
  double delay = 0;    ///< by which that is late [s]
  /// East, north, up of a datum [m].
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  double sigma = 0;     ///< of each horizontal axis, as stated [m]; 0: not stated
  double sigma_up = 0;  ///< of the height, as stated [m]; 0: not stated
  Eigen::Vector3d antenna = Eigen::Vector3d::Zero();  ///< on the robot [m]
  /// Where the robot was at the time of the fix, in the frame of the keyframe that it is given to,
  /// as odometry tells.
  Eigen::Isometry3d T_keyframe_robot = Eigen::Isometry3d::Identity();
  std::shared_ptr<const FixModel> receiver;  ///< as measured; null: as the mapper has it
  std::size_t row = 0;                       ///< which fix of the log it is

  /// Where the antenna was, in the frame of the keyframe [m].
  Eigen::Vector3d lever_arm() const { return T_keyframe_robot * antenna; }
};

/// Which receiver: its robot, and the label of its sensor.
using ReceiverId = std::pair<std::size_t, std::string>;

/// What became of a fix.
struct FixEntry {
  Fix fix;
  std::size_t robot = 0;
  Key pose;  ///< of its keyframe
  /// Its error that lasts, and the mode of that; nothing where the fix is not in the map.
  std::optional<Key> error;
  DiscreteKey mode;            ///< an ErrorMode
  std::optional<Key> falsity;  ///< whether it is false: 1
  bool is_plain = false;       ///< in the map without modes
  std::string unused;          ///< why it is not in the map

  ReceiverId receiver() const { return {robot, fix.sensor}; }
};

}  // namespace hybrid
