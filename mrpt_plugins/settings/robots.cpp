// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/settings/detail/robots.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/robot_sections.h"

namespace hybrid {
namespace {

constexpr const char* kTruths[] = {"truth_path", "truth_associations", "truth_modes",
                                   "truth_fixes"};
constexpr const char* kAdvice = "--truth-path NAME=FILE and --truth-map give those of these logs";
/// Sections of which a robot may have values of its own, as SECTION.KEY.
constexpr const char* kSections[] = {"reader", "keyframes", "sensor",     "odometry",
                                     "motion", "prior",     "calibration"};

/// A key that robots have under a name of their own.
struct RobotKey {
  const char *name, *section;
  bool path;
  const char* meaning;
};
constexpr RobotKey kKeys[] = {
    {"rawlog", "log", true, "its log"},
    {"truth_path", "log", true, "its true path, as in [log]"},
    {"truth_associations", "log", true, "what its measurements saw, as in [log]"},
    {"truth_modes", "log", true, "its true modes of motion, as in [log]"},
    {"truth_fixes", "log", true, "what its fixes are, as in [log]"},
    {"truth_step", "log", false, "step of its log that the first row of truth_path is of"},
    {"truth_point", "log", false, "place on it of what gave the true positions, as in [log]"},
    {"start", "map", false, "its first pose in the map, as in [map]"},
    {"start_sigma_m", "map", false, "as in [map]"},
    {"start_sigma_deg", "map", false, "as in [map]"},
    {"clock_offset", "reader", false, "added to its time stamps, as in [reader]"},
};

const RobotKey* find_key(const std::string& key) {
  const auto it = std::find_if(std::begin(kKeys), std::end(kKeys),
                               [&](const RobotKey& k) { return key == k.name; });
  return it == std::end(kKeys) ? nullptr : it;
}

/// Section and key that a key of a robot stands for.
std::pair<std::string, std::string> meant(const IniSection& section, const std::string& key) {
  if (const RobotKey* own = find_key(key)) return {own->section, key};
  const auto parts = split_key(key);
  if (parts &&
      std::find(std::begin(kSections), std::end(kSections), parts->first) != std::end(kSections)) {
    return *parts;
  }
  std::vector<std::string> names = {"id", "plugins"};
  for (const RobotKey& k : kKeys) names.emplace_back(k.name);
  section.fail(key, fmt::format("is nothing that a robot has of its own; known are {} and "
                                "SECTION.KEY of {}",
                                fmt::join(names, ", "), fmt::join(kSections, ", ")));
}

}  // namespace

void leave_out_truth(IniFile& ini, const std::string& section_name, bool with_map,
                     const std::string& advice) {
  IniSection section = ini.section(section_name);
  std::vector<std::string> keys(std::begin(kTruths), std::end(kTruths));
  if (with_map) keys.insert(keys.end(), {"truth_map", "truth_movers"});
  std::string left_out;
  for (const std::string& key : keys) {
    if (section.is_overridden(key) || !section.has(key) || section.path(key, "", "").empty()) {
      continue;
    }
    left_out += (left_out.empty() ? "" : ", ") + key;
    ini.override_value(section_name, key, "", ini.name());
  }
  if (left_out.empty()) return;
  section.warn("rawlog", "is another log than that of " + ini.name() + ", whose " + left_out +
                             " are left out; " + advice);
}

std::string title_of(const std::vector<std::string>& robots) {
  return fmt::format("robots {}", fmt::join(robots, ", "));
}

void take_robots(IniFile& ini, const std::vector<RequestedRobot>& robots) {
  const std::vector<std::string> before = robot_names(ini);
  for (const RequestedRobot& robot : robots) {
    const std::string section = robot_section(robot.name);
    const bool known = std::find(before.begin(), before.end(), robot.name) != before.end();
    if (!known && robot.rawlog.empty()) {
      throw Error(fmt::format("--truth-path {}={}: there is no robot of that name", robot.name,
                              robot.truth_path));
    }
    if (!robot.truth_path.empty()) ini.override_value(section, "truth_path", robot.truth_path);
    if (robot.rawlog.empty()) continue;
    ini.override_value(section, "rawlog", robot.rawlog);
    if (known) leave_out_truth(ini, section, false, kAdvice);
  }
  if (robots.empty() || !before.empty()) return;
  leave_out_truth(ini, "log", true, kAdvice);
  ini.override_value("log", "rawlog", "", ini.name());
  if (ini.section("log").is_overridden("title")) return;
  ini.override_value("log", "title", title_of(robot_names(ini)), ini.name());
}

RobotSection read_robot(IniFile& ini, const std::string& name, std::unique_ptr<IniFile> fresh) {
  RobotSection out;
  out.ini = std::move(fresh);
  IniSection section = ini.section(robot_section(name), "A robot; see docs/robots.md");
  for (const char* key : kTruths) out.ini->override_value("log", key, "", ini.name());
  out.ini->override_value("map", "start", "", ini.name());
  for (const std::string& key : section.keys()) {
    if (key == "id") {
      out.id = section.get(key, std::int64_t{0}, "the id that sensors of other robots give it");
      if (*out.id == -1) section.fail(key, "is the id of nothing; any other will do");
    } else if (key == "plugins") {
      out.plugins = section.get(key, out.plugins,
                                "those of [plugins] classes that see what it observes; by default "
                                "all");
    } else {
      const auto [of, target] = meant(section, key);
      const RobotKey* own = find_key(key);
      const std::string meaning =
          own != nullptr ? own->meaning : "instead of [" + of + "] " + target;
      const bool is_path = own != nullptr && own->path;
      std::string value = is_path ? section.path(key, "", meaning) : section.get(key, "", meaning);
      if (is_path && !value.empty()) value = std::filesystem::absolute(value).string();
      out.ini->override_value(of, target, value, section.place(key));
    }
  }
  return out;
}

void check_robot(IniFile& ini, const std::string& name, const IniFile& own) {
  IniSection section = ini.section(robot_section(name));
  for (const std::string& key : section.keys()) {
    if (key == "id" || key == "plugins") continue;
    const auto [of, target] = meant(section, key);
    if (!own.declares(of, target)) section.fail(key, "is no key of [" + of + "]");
  }
}

}  // namespace hybrid
