// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "libhybrid/maps/map_record.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/settings/replay_request.h"
#include "mrpt_plugins/settings/replay_settings.h"

namespace HYBRID_API hybrid {

/// The starts of the robots of a replay. The frame is that of a known map, if one of them is found
/// in it, and else that of the first robot. A start that is not given is found: in the known map
/// by the landmarks of the robot as they come; else the robot is mapped alone, and its landmarks
/// say where its map is in that of the others, as in joining maps. A robot whose place does not
/// stand out is left out. Of one robot without a known map nothing is looked for.
class Team {
 public:
  /// Finds the starts and enters them into the settings, which keep the robots that have one.
  /// `known` has no landmarks where there is no map. Throws as replay does.
  Team(const ReplayRequest& request, ReplaySettings& settings, const MapRecord& known, bool is_3d);

  /// Tells that the mapper has one more keyframe of a robot. Once it has all by which the start was
  /// found, that is given up: they tell it again in the joint map.
  void added(std::size_t robot, Mapper& mapper);

  /// Whether the frame is that of the known map.
  bool is_in_map() const { return in_map_; }
  /// The keyframe of a robot, by its own count, at which its start was known; 0 where it is given.
  std::optional<std::size_t> known_at(std::size_t robot) const { return members_[robot].known_at; }
  /// Which robots were left out and why; empty where none was.
  const std::string& message() const { return message_; }

 private:
  struct Member {
    std::optional<std::size_t> known_at;
    bool given = false;         // the start, by the settings
    std::size_t keyframes = 0;  // in the mapper
  };
  void leave_out(const std::vector<std::size_t>& lost, std::vector<RobotSettings>& robots);

  std::vector<Member> members_;
  bool in_map_ = false;
  std::string message_;
};

}  // namespace hybrid
