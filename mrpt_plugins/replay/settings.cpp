// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/settings.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <utility>

#include "mrpt_plugins/bridge/detail/standard_input.h"
#include "mrpt_plugins/mapping/plugin_choice.h"

namespace hybrid {
namespace {

constexpr const char* kAuto = "auto";

std::string stem_of(const std::string& path) {
  return std::filesystem::path(shown_path(path)).stem().string();
}

/// The path of a file; fails where it is that of a folder, which the one who reads the file could
/// not say the key of.
std::string file_path(IniSection& section, const std::string& key, const std::string& meaning) {
  const std::string path = section.path(key, "", meaning);
  std::error_code unknown;
  if (!path.empty() && std::filesystem::is_directory(path, unknown)) {
    section.fail(key, "'" + path + "' is a folder, not a file");
  }
  return path;
}

/// What an INI says of its own log alone.
constexpr const char* kOfTheLog[] = {"truth_path", "truth_map", "truth_associations",
                                     "truth_modes"};

bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code unknown;
  return a == b || std::filesystem::equivalent(a, b, unknown);
}

/// Takes the files of the command line. Where it names another log than the INI, what the INI says
/// is true is not true of that: it is left out with a warning.
void take_command_line(IniFile& ini, const ReplayRequest& request) {
  const std::string log_of_ini = ini.section("log").path("rawlog", "", "the log");
  ini.override_values(request.settings);
  const std::pair<const char*, const std::string&> files[] = {{"rawlog", request.rawlog},
                                                              {"truth_path", request.truth_path},
                                                              {"truth_map", request.truth_map}};
  for (const auto& [key, path] : files) {
    if (!path.empty()) ini.override_value("log", key, path);
  }
  IniSection log = ini.section("log");
  const std::string present = log.path("rawlog", "", "the log");
  if (log_of_ini.empty() || is_same_file(present, log_of_ini)) return;
  std::string left_out;
  for (const char* key : kOfTheLog) {
    if (log.is_overridden(key) || log.path(key, "", "").empty()) continue;
    left_out += (left_out.empty() ? "" : ", ") + std::string(key);
    ini.override_value("log", key, "", ini.name());
  }
  if (!log.is_overridden("title")) ini.override_value("log", "title", stem_of(present));
  if (left_out.empty()) return;
  log.warn("rawlog", "is another log than that of " + ini.name() + ", whose " + left_out +
                         " are left out; --truth-path and --truth-map give those of this log");
}

void read_log(IniFile& ini, ReplaySettings& settings) {
  IniSection log = ini.section("log", "What is replayed; paths are relative to this file");
  settings.rawlog = file_path(log, "rawlog", "the log; - is standard input");
  settings.truth_path = file_path(log, "truth_path",
                                  "true path of the robot, MRPT's _ground_truth_robot_path.txt, "
                                  "TUM (.tum) or `time x y z` (.xyz); empty: unknown");
  const auto point = log.get("truth_point", std::vector<double>{0, 0, 0},
                             "place on the robot of what gave the positions of a .xyz file, such "
                             "as the antenna [m]",
                             kCoordinate);
  if (point.size() != 3) log.fail("truth_point", "needs three numbers");
  settings.truth_point = Eigen::Map<const Eigen::Vector3d>(point.data());
  settings.truth_map =
      file_path(log, "truth_map", "true landmarks, MRPT's _ground_truth.txt; empty: unknown");
  settings.truth_associations =
      file_path(log, "truth_associations",
                "what measurements without an id saw, `step,measurement,true_id`; empty: unknown");
  settings.truth_modes =
      file_path(log, "truth_modes", "true modes of motion, a number per frame; empty: unknown");
  settings.title = log.get("title", stem_of(settings.rawlog), "heading of the pictures");
}

/// All but the plugins.
ReplaySettings read_all_but_plugins(IniFile& ini, const ReplayRequest& request) {
  ReplaySettings settings;
  take_command_line(ini, request);
  read_log(ini, settings);
  settings.match_radius =
      ini.section("evaluation", "Comparison with the truth")
          .get("match_radius", settings.match_radius,
               "where the ids of the log are not taken for granted, a landmark counts as found if "
               "one of the map is this near, each taken once [m]",
               kPositiveLength);
  settings.source = read_source_options(ini);
  settings.source.reader.libraries = request.plugin_libraries;
  settings.map = read_map_options(ini, request);
  settings.motion = read_motion_options(ini);
  settings.calibration = read_calibration_options(ini);
  settings.backend = make_backend(ini.section("solver", "How the estimate is found"));
  return settings;
}

/// The names of [plugins] classes; "auto" stands alone.
std::vector<std::string> read_plugin_names(IniFile& ini) {
  return ini.section("plugins", "What turns observations into factors")
      .get("classes", std::vector<std::string>{kAuto},
           "class names of mapping plugins, each with a section of its own name; auto: those that "
           "suit what the log holds");
}

bool is_auto(const std::vector<std::string>& names) {
  return names.size() == 1 && names.front() == kAuto;
}

/// Fails where a log from standard input would have to be read before it is mapped.
void reject_second_reading(const ReplayRequest& request, const SourceOptions& source,
                           bool auto_plugins) {
  const std::string reason = "standard input is read once, as it comes: ";
  std::string lacking;
  if (auto_plugins) lacking = "[plugins] classes, such as BearingRangeKnownIds";
  if (source.dimension == Dimension::kAuto) {
    lacking += std::string(lacking.empty() ? "" : ", and ") + "[map] dimension, 2 or 3";
  }
  if (!lacking.empty()) throw Error(reason + "give " + lacking + "; auto would read ahead");
  if (request.frames > 0 || !request.video.empty()) {
    throw Error(reason + "--frames and --video need a file, to know how many keyframes there are");
  }
  if (request.resume) throw Error(reason + "--resume needs a file, whose start it reads again");
}

}  // namespace

ReplaySettings read_settings(IniFile& ini, const ReplayRequest& request) {
  ReplaySettings settings = read_all_but_plugins(ini, request);
  const std::vector<std::string> names = read_plugin_names(ini);
  std::map<std::string, std::shared_ptr<MappingPlugin>> made;
  const auto make = [&](const std::string& name) {
    auto& plugin = made[without_namespace(name)];
    if (!plugin) plugin = make_plugin(name, ini);
    return plugin;
  };
  if (!is_auto(names)) {
    for (const std::string& name : names) settings.plugins.push_back(make(name));
  }
  for (const std::string& name : registered_plugins()) {
    if (ini.has_section(name)) make(name);
  }
  ini.reject_unknown();
  if (settings.rawlog.empty()) {
    ini.section("log").fail("rawlog", "names no log, and neither does the command line");
  }
  if (is_standard_input(settings.rawlog)) {
    reject_second_reading(request, settings.source, is_auto(names));
  }
  if (is_auto(names)) {
    settings.chosen = choose_plugins(read_contents(settings.rawlog, settings.source));
    for (const std::string& name : settings.chosen) settings.plugins.push_back(make(name));
  }
  for (const auto& plugin : settings.plugins) {
    const auto classes = plugin->observation_classes();
    auto& asked = settings.source.reader.request.classes;
    asked.insert(asked.end(), classes.begin(), classes.end());
  }
  return settings;
}

std::unique_ptr<IniFile> open_config(const ReplayRequest& request) {
  if (request.config.empty()) return std::make_unique<IniFile>("", "(defaults)");
  return std::make_unique<IniFile>(std::filesystem::path(request.config));
}

std::string config_text(const ReplayRequest& request) {
  const std::unique_ptr<IniFile> ini = open_config(request);
  read_all_but_plugins(*ini, request);
  std::vector<std::string> names = read_plugin_names(*ini);
  const std::vector<std::string> registered = registered_plugins();
  if (is_auto(names)) names = registered;
  for (const std::string& name : names) make_plugin(name, *ini);
  for (const std::string& name : registered) {
    const bool is_made = std::any_of(names.begin(), names.end(), [&](const std::string& made) {
      return without_namespace(made) == name;
    });
    if (!is_made && ini->has_section(name)) make_plugin(name, *ini);
  }
  ini->reject_unknown();
  return ini->documentation();
}

}  // namespace hybrid
