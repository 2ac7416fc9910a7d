// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/settings.h"

#include <filesystem>

namespace hybrid {
namespace {

std::string chosen(const std::string& from_command_line, const std::string& from_ini) {
  return from_command_line.empty() ? from_ini : from_command_line;
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

void read_log(IniFile& ini, const ReplayRequest& request, ReplaySettings& settings) {
  IniSection log = ini.section("log", "What is replayed; paths are relative to this file");
  settings.rawlog = chosen(request.rawlog, file_path(log, "rawlog", "the log"));
  settings.truth_path = chosen(
      request.truth_path, file_path(log, "truth_path",
                                    "true path of the robot, MRPT's _ground_truth_robot_path.txt, "
                                    "TUM (.tum) or `time x y z` (.xyz); empty: unknown"));
  const auto point = log.get("truth_point", std::vector<double>{0, 0, 0},
                             "place on the robot of what gave the positions of a .xyz file, such "
                             "as the antenna [m]",
                             kCoordinate);
  if (point.size() != 3) log.fail("truth_point", "needs three numbers");
  settings.truth_point = Eigen::Map<const Eigen::Vector3d>(point.data());
  settings.truth_map =
      chosen(request.truth_map, file_path(log, "truth_map",
                                          "true landmarks, MRPT's _ground_truth.txt; empty: "
                                          "unknown"));
  settings.truth_associations =
      file_path(log, "truth_associations",
                "what measurements without an id saw, `step,measurement,true_id`; empty: unknown");
  settings.truth_modes =
      file_path(log, "truth_modes", "true modes of motion, a number per frame; empty: unknown");
  settings.title = log.get("title", std::filesystem::path(settings.rawlog).stem().string(),
                           "heading of the pictures");
}

}  // namespace

ReplaySettings read_settings(IniFile& ini, const ReplayRequest& request) {
  ReplaySettings settings;
  ini.override_values(request.settings);
  read_log(ini, request, settings);
  settings.match_radius =
      ini.section("evaluation", "Comparison with the truth")
          .get("match_radius", settings.match_radius,
               "where the ids of the log are not taken for granted, a landmark counts as found if "
               "one of the map is this near, each taken once [m]",
               kPositiveLength);
  settings.source = read_source_options(ini);
  settings.map = read_map_options(ini, request);
  settings.motion = read_motion_options(ini);
  settings.calibration = read_calibration_options(ini);
  settings.backend = make_backend(ini.section("solver", "How the estimate is found"));
  IniSection plugins = ini.section("plugins", "What turns observations into factors");
  const auto names =
      plugins.get("classes", std::vector<std::string>{"BearingRangeKnownIds"},
                  "class names of mapping plugins; each has a section of its own name");
  const bool document_all = request.config.empty();
  for (const std::string& name : document_all ? registered_plugins() : names) {
    settings.plugins.push_back(make_plugin(name, ini));
    const auto classes = settings.plugins.back()->observation_classes();
    auto& asked = settings.source.reader.request.classes;
    asked.insert(asked.end(), classes.begin(), classes.end());
  }
  settings.source.reader.libraries = request.plugin_libraries;
  ini.reject_unknown();
  return settings;
}

std::string config_text(const ReplayRequest& request) {
  if (request.config.empty()) {
    IniFile ini;
    read_settings(ini, request);
    return ini.documentation();
  }
  IniFile ini(request.config);
  read_settings(ini, request);
  return ini.documentation();
}

}  // namespace hybrid
