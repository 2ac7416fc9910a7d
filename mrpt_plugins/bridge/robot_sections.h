// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Several robots in one INI: each a section [robot.NAME], with values of its own as SECTION.KEY.

#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mrpt_plugins/bridge/ini_file.h"

namespace HYBRID_API hybrid {

/// Whether a robot may have this name: up to 64 letters, digits, _ and -, as a file may be named.
bool is_robot_name(const std::string& name);

/// The names of the robots of an INI in order. Throws Error for a name that makes no file name.
std::vector<std::string> robot_names(const IniFile& ini);

/// The section of a robot.
std::string robot_section(const std::string& robot);

/// SECTION and KEY of "SECTION.KEY"; nothing where there is no dot.
std::optional<std::pair<std::string, std::string>> split_key(const std::string& text);

}  // namespace hybrid
