// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/bridge/ini_file.h"
#include "mrpt_plugins/settings/replay_request.h"

namespace hybrid {

/// The heading of pictures where the INI gives none.
std::string title_of(const std::vector<std::string>& robots);

/// Leaves out what a section of the INI says is true of a log which another one stands for now,
/// also of the map where asked for; warns, with advice on how to give it.
void leave_out_truth(IniFile& ini, const std::string& section, bool with_map,
                     const std::string& advice);

/// Takes the robots of the command line over into the INI. What that says is true of a log which
/// another one stands for now is left out, with a warning.
void take_robots(IniFile& ini, const std::vector<RequestedRobot>& robots);

/// What a robot has of its own beside a log.
struct RobotSection {
  std::optional<std::int64_t> id;    ///< that sensors of other robots give it
  std::vector<std::string> plugins;  ///< that see what it observes; empty: all
  /// The INI as this robot has it: with its own values in place of those of all.
  std::unique_ptr<IniFile> ini;
};

/// Reads [robot.NAME]; `fresh` is the INI anew, with the values of the command line. Throws Error
/// for keys that a robot cannot have of its own.
RobotSection read_robot(IniFile& ini, const std::string& name, std::unique_ptr<IniFile> fresh);

/// Throws Error where a key of [robot.NAME] is none that its INI declares; to be called once all is
/// read from that.
void check_robot(IniFile& ini, const std::string& name, const IniFile& own);

}  // namespace hybrid
