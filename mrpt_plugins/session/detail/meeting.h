// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "libhybrid/detections/detection.h"
#include "libhybrid/maps/align_frames.h"
#include "libhybrid/maps/map_record.h"
#include "mrpt_plugins/bridge/timed_pose.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/session/detail/find_start.h"
#include "mrpt_plugins/settings/replay_request.h"
#include "mrpt_plugins/settings/replay_settings.h"

namespace hybrid {

/// Robots whose starts are found one after the other, each by the map that it makes alone: by
/// landmarks, or what laser scans or clouds saw, which that has in common with the maps of the
/// others, or by where it saw them and they saw it.
class Meeting {
 public:
  /// `joint` is a known map; without landmarks, it becomes the map of the first robot.
  Meeting(const ReplayRequest& request, const ReplaySettings& settings, MapRecord joint);

  /// Where robot `i` starts in the frame of `joint`; nothing where that cannot be told yet.
  std::optional<FoundStart> find(std::size_t i);

  /// Tells where the map that a robot makes alone is.
  void place(std::size_t i, const Eigen::Isometry3d& T_joint_own) { placed_[i] = T_joint_own; }

 private:
  /// In the frame of the first pose of the robot, or where its start is given.
  struct OwnMap {
    MapRecord map;
    Trajectory trajectory;
    std::vector<std::vector<DetectionFrame>> robots;  // that it saw, by keyframe
    Eigen::MatrixXd covariance;                       // of the first pose, with fixes
  };
  /// Maps that are one, and where their frame is.
  struct Part {
    MapRecord map;
    Eigen::Isometry3d T_joint_part;
  };

  OwnMap map_alone(std::size_t robot) const;
  static void set_origin(const MapDatum& datum, const Mapper& mapper, OwnMap& out);
  const OwnMap& own(std::size_t i);
  std::optional<KnownStart> by_landmarks(std::size_t i);
  std::optional<KnownStart> by_places(std::size_t i);
  std::optional<KnownStart> by_sightings(std::size_t i);
  std::optional<KnownStart> by_fixes(std::size_t i);
  std::vector<CommonPoint> sightings(std::size_t observer, std::size_t other);

  const ReplayRequest& request_;
  double odds_;
  std::vector<std::optional<std::int64_t>> ids_;  // of robots, as others see them
  std::map<std::size_t, OwnMap> maps_;
  std::map<std::size_t, Eigen::Isometry3d> placed_;  // T_joint_own
  std::vector<Part> parts_;
};

}  // namespace hybrid
