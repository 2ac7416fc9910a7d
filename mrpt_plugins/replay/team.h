// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/replay/replay_request.h"
#include "mrpt_plugins/replay/settings.h"

namespace HYBRID_API hybrid {

/// The starts of the robots of a replay in the frame of the first; where there is but one robot,
/// all of this does nothing. A start that is not given is found: the robot is mapped alone, and
/// its landmarks say where its map lies in that of the others, as in joining maps. A robot whose
/// place does not stand out is left out.
class Team {
 public:
  /// Finds the starts and enters them into the settings. Throws as replay does.
  Team(const ReplayRequest& request, ReplaySettings& settings);

  /// Gives up what was found of the starts, which the measurements of the joint map tell again.
  void settle(Mapper& mapper) const;

  /// Which robots were left out and why; empty where none was.
  const std::string& message() const { return message_; }

 private:
  std::vector<std::size_t> found_;  // robots
  std::string message_;
};

}  // namespace hybrid
