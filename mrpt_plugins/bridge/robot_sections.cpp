// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/robot_sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "libhybrid/core/error.h"
#include "libhybrid/io/escaped.h"

namespace hybrid {
namespace {

constexpr const char* kPrefix = "robot.";
constexpr std::size_t kLongestName = 64;

}  // namespace

bool is_robot_name(const std::string& name) {
  return !name.empty() && name.size() <= kLongestName &&
         std::all_of(name.begin(), name.end(),
                     [](unsigned char c) { return std::isalnum(c) != 0 || c == '_' || c == '-'; });
}

std::vector<std::string> robot_names(const IniFile& ini) {
  std::vector<std::string> names;
  const std::string prefix = kPrefix;
  for (const std::string& section : ini.sections()) {
    if (section.rfind(prefix, 0) != 0) continue;
    names.push_back(section.substr(prefix.size()));
    if (is_robot_name(names.back())) continue;
    throw Error(
        fmt::format("{}: [{}]: the name of a robot is made of letters, digits, _ and -, {} "
                    "at most",
                    ini.name(), escaped(section), kLongestName));
  }
  return names;
}

std::string robot_section(const std::string& robot) {
  return kPrefix + robot;
}

std::optional<std::pair<std::string, std::string>> split_key(const std::string& text) {
  const std::size_t dot = text.find('.');
  if (dot == std::string::npos) return std::nullopt;
  return std::pair(text.substr(0, dot), text.substr(dot + 1));
}

}  // namespace hybrid
