// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/settings/replay_settings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "mrpt_plugins/bridge/robot_sections.h"
#include "mrpt_plugins/bridge/standard_input.h"
#include "mrpt_plugins/mapping/fix_source.h"
#include "mrpt_plugins/mapping/plugin_choice.h"
#include "mrpt_plugins/settings/detail/robots.h"
#include "mrpt_plugins/survey/fix_survey.h"
#include "mrpt_plugins/survey/laser_survey.h"
#include "mrpt_plugins/survey/log_survey.h"

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

bool is_same_file(const std::string& a, const std::string& b) {
  std::error_code unknown;
  return a == b || std::filesystem::equivalent(a, b, unknown);
}

/// Takes the files of the command line. Where it names another log than the INI, what the INI says
/// is true is not true of that: it is left out with a warning.
void take_command_line(IniFile& ini, const ReplayRequest& request) {
  const std::string log_of_ini = ini.section("log").path("rawlog", "", "the log");
  ini.override_values(request.settings);
  take_robots(ini, request.robots);
  const std::pair<const char*, const std::string&> files[] = {{"rawlog", request.rawlog},
                                                              {"truth_path", request.truth_path},
                                                              {"truth_map", request.truth_map}};
  for (const auto& [key, path] : files) {
    if (!path.empty()) ini.override_value("log", key, path);
  }
  IniSection log = ini.section("log");
  const std::string present = log.path("rawlog", "", "the log");
  if (present.empty() || log_of_ini.empty() || is_same_file(present, log_of_ini)) return;
  leave_out_truth(ini, "log", true, "--truth-path and --truth-map give those of this log");
  if (!log.is_overridden("title")) ini.override_value("log", "title", stem_of(present));
}

/// Section [log]; what is common to all robots goes into `settings`.
void read_log(IniFile& ini, ReplaySettings& settings, RobotSettings& robot) {
  IniSection log = ini.section("log", "What is replayed; paths are relative to this file");
  robot.rawlog = file_path(log, "rawlog", "the log; - is standard input");
  robot.truth_path = file_path(log, "truth_path",
                               "true path of the robot, MRPT's _ground_truth_robot_path.txt, "
                               "_GT.txt, TUM (.tum) or `time x y z` (.xyz); empty: unknown");
  robot.truth_step = static_cast<std::size_t>(
      log.get("truth_step", 0,
              "step of the log that the first row of a true path without times is of: 1 where the "
              "log has a frame before its first action, and the rows begin with that action",
              {0, 1e9}));
  const auto point = log.get("truth_point", std::vector<double>{0, 0, 0},
                             "place on the robot of what gave the positions of a .xyz file, such "
                             "as the antenna [m]",
                             kCoordinate);
  if (point.size() != 3) log.fail("truth_point", "needs three numbers");
  robot.truth_point = Eigen::Map<const Eigen::Vector3d>(point.data());
  const auto datum =
      log.get("truth_datum", std::vector<double>{},
              "latitude, longitude [deg] and altitude [m] to whose east, north and up the true "
              "path refers: a map with fixes is compared where it lies on earth; empty: unknown",
              kCoordinate);
  if (!datum.empty()) {
    const bool is_place = datum.size() == 3 && std::abs(datum[0]) <= 90;
    if (!is_place) log.fail("truth_datum", "needs latitude, longitude and altitude");
    settings.truth_datum = {datum[0], datum[1], datum[2]};
  }
  settings.truth_map =
      file_path(log, "truth_map", "true landmarks, MRPT's _ground_truth.txt; empty: unknown");
  settings.truth_movers = file_path(
      log, "truth_movers",
      "where things that move were, `step,id,x,y,z`, those with one robot; empty: unknown");
  robot.truth_associations =
      file_path(log, "truth_associations",
                "what measurements without an id saw, `step,measurement,true_id`; empty: unknown");
  robot.truth_modes =
      file_path(log, "truth_modes", "true modes of motion, a number per frame; empty: unknown");
  robot.truth_fixes = file_path(log, "truth_fixes",
                                "what satellite fixes are, `time,mode,error_east,error_north,"
                                "error_up` with mode good, biased or false; empty: unknown");
  settings.title = log.get("title", settings.title.empty() ? stem_of(robot.rawlog) : settings.title,
                           "heading of the pictures");
}

/// What a robot may have of its own, and all but the plugins of what is common to all.
RobotSettings read_one(IniFile& ini, const ReplayRequest& request, ReplaySettings& settings) {
  RobotSettings robot;
  read_log(ini, settings, robot);
  ini.section("evaluation", "Comparison with the truth")
      .read("match_radius", settings.match_radius,
            "where the ids of the log are not taken for granted, a landmark counts as found if one "
            "of the map is this near, each taken once [m]",
            kPositiveLength);
  robot.source = read_source_options(ini);
  robot.source.reader.libraries = request.plugin_libraries;
  settings.map = read_map_options(ini, request);
  if (settings.map.file.empty()) robot.source.reader.request.parsed = request.parsed;
  robot.start = settings.map.start;
  robot.options.motion = read_motion_options(ini);
  robot.options.calibration = read_calibration_options(ini);
  return robot;
}

void read_meetings(IniFile& ini, ReplaySettings& settings) {
  IniSection robots =
      ini.section("robots", "Where there are several robots, each a section [robot.NAME]");
  robots.read("sightings", settings.sightings,
              "use what they see of each other, by the id of each");
  robots.read("huber_width", settings.huber_width,
              "for ids that are sometimes misread: beyond so many sigmas the cost of such a "
              "sighting grows only linearly; 0: none is wrong",
              or_zero({1e-3, 1e3}));
}

/// The settings of the robots that the INI names, of which each reads it with values of its own.
void read_robots(IniFile& ini, const ReplayRequest& request, const std::vector<std::string>& names,
                 ReplaySettings& settings) {
  std::set<std::int64_t> ids;
  for (const std::string& name : names) {
    auto fresh = open_config(request);
    fresh->override_values(request.settings);
    RobotSection section = read_robot(ini, name, std::move(fresh));
    ReplaySettings shared;
    RobotSettings robot = read_one(*section.ini, request, shared);
    check_robot(ini, name, *section.ini);
    if (robot.rawlog.empty()) ini.section(robot_section(name)).fail("rawlog", "names no log");
    robot.name = robot.options.name = name;
    robot.options.id = section.id;
    robot.plugins = section.plugins;
    if (section.id) ids.insert(*section.id);
    settings.robots.push_back(std::move(robot));
  }
  for (RobotSettings& robot : settings.robots) robot.source.detections.robots = ids;
}

/// All but the plugins.
ReplaySettings read_all_but_plugins(IniFile& ini, const ReplayRequest& request) {
  ReplaySettings settings;
  take_command_line(ini, request);
  const std::vector<std::string> names = robot_names(ini);
  if (!names.empty()) settings.title = title_of(names);
  RobotSettings robot = read_one(ini, request, settings);
  settings.backend = make_backend(ini.section("solver", "How the estimate is found"));
  read_meetings(ini, settings);
  if (names.empty()) {
    settings.robots.push_back(std::move(robot));
    return settings;
  }
  if (!robot.rawlog.empty()) {
    ini.section("log").fail("rawlog",
                            "is one log, but there are sections [robot.NAME], each of "
                            "which names its own");
  }
  read_robots(ini, request, names, settings);
  return settings;
}

/// The names of [plugins] classes; "auto" stands alone.
std::vector<std::string> read_plugin_names(IniFile& ini) {
  return ini.section("plugins", "What turns observations into factors")
      .get("classes", std::vector<std::string>{kAuto},
           "class names of mapping plugins, each with a section of its own name; auto: those that "
           "suit what the log holds");
}

std::string read_scans_choice(IniFile& ini) {
  return ini.section("map").choice(
      "scans", kAuto, {kAuto, "yes", "no"},
      "keep laser scans for map.pgm, map.simplemap, the pictures and a pose for each in "
      "trajectory.tum; auto: where a plugin maps them");
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
  if (request.frames > 0) {
    throw Error(reason + "--frames needs a file, to know how many keyframes there are");
  }
  if (request.resume) throw Error(reason + "--resume needs a file, whose start it reads again");
}

/// Where nothing but scans is mapped, whose plugins take those between keyframes as well: keyframes
/// are some motion apart, by each threshold that is not given.
void space_keyframes(ReplaySettings& settings) {
  const auto& plugins = settings.plugins;
  const bool only_scans =
      !plugins.empty() && std::all_of(plugins.begin(), plugins.end(), [](const auto& plugin) {
        return plugin->takes_scans_between();
      });
  if (!only_scans) return;
  for (RobotSettings& robot : settings.robots) {
    SourceOptions& source = robot.source;
    if (!source.has_keyframe_distance) source.keyframes.min_distance = kScanKeyframes.min_distance;
    if (!source.has_keyframe_angle) source.keyframes.min_angle = kScanKeyframes.min_angle;
    source.follows_scans = !source.has_keyframe_distance || !source.has_keyframe_angle;
  }
}

/// Whether scans are kept for the outputs, where that is up to the plugins.
bool keeps_scans(const std::string& choice, const ReplaySettings& settings) {
  if (choice != kAuto) return choice == "yes";
  return std::any_of(settings.plugins.begin(), settings.plugins.end(),
                     [](const auto& plugin) { return plugin->takes_scans_between(); });
}

/// Reads the logs that are to be measured, or all; sets what was found, and returns what they hold.
/// Ids of a tracker are found in all that are read. Standard input and pipes are read once, so that
/// they are taken at their word.
LogContents read_logs(ReplaySettings& settings, bool all) {
  LogContents contents;
  for (RobotSettings& robot : settings.robots) {
    std::error_code unknown;
    const bool surveyed = robot.source.noise != NoiseSource::kStated &&
                          !is_standard_input(robot.rawlog) &&
                          std::filesystem::is_regular_file(robot.rawlog, unknown);
    const bool measured = surveyed && robot.source.noise == NoiseSource::kMeasured;
    if (!all && !measured) continue;
    LogSurvey survey(robot.source, !robot.options.calibration.sensor_pose);
    LaserSurvey lasers(robot.source.scans);
    FixSurvey fixes(robot.source.reader.clock_offset);
    const bool measures_lasers = robot.source.noise != NoiseSource::kStated;
    const StepWatcher watcher = [&](const LogStep& step,
                                    const std::vector<DetectionFrame>& frames) {
      if (surveyed) survey.add(step, frames);
      if (measures_lasers) lasers.add(step);
      if (surveyed) fixes.add(step);
    };
    LogContents own = read_contents(robot.rawlog, robot.source, watcher);
    robot.source.steps = own.steps;
    if (surveyed) robot.findings = measured ? survey.conclude() : survey.conclude_ids();
    // Among others, a robot whose sign or unit is wrong does not make the map bad.
    if (surveyed && !measured && settings.robots.size() > 1) {
      robot.findings.alignment = survey.contradictions();
    }
    lasers.conclude(robot.findings);
    robot.findings.fixes = fixes.release();
    const double stated = robot.source.correction.translation;
    robot.source.correction = robot.findings.correction;
    robot.source.correction.translation *= stated;
    robot.source.correction.rotation *= stated;
    if (robot.source.correction.hides_ids) own.forget_ids();
    contents.add(own);
  }
  return contents;
}

/// Measures the receivers of logs that were read; odometry as well where fixes alone tell of it.
void measure_receivers(ReplaySettings& settings) {
  const FixSource* source = fix_source_of(settings.plugins);
  for (RobotSettings& robot : settings.robots) {
    if (source == nullptr || robot.source.noise == NoiseSource::kStated) continue;
    measure_fixes(source->fix_mapper().model(), settings.plugins.size() == 1, robot.findings,
                  robot.source.correction);
  }
}

/// Which of the plugins see what each robot observes.
void choose_plugins_of_robots(IniFile& ini, const std::vector<std::string>& all,
                              ReplaySettings& settings) {
  for (RobotSettings& robot : settings.robots) {
    if (robot.plugins.empty()) continue;
    std::vector<bool>& sees = robot.options.plugins;
    sees.assign(all.size(), false);
    for (const std::string& name : robot.plugins) {
      const auto it = std::find_if(all.begin(), all.end(), [&](const std::string& other) {
        return without_namespace(other) == without_namespace(name);
      });
      if (it == all.end()) {
        ini.section(robot_section(robot.name))
            .fail("plugins", fmt::format("names {}, which is none of [plugins] classes = {}", name,
                                         fmt::join(all, " ")));
      }
      sees[static_cast<std::size_t>(it - all.begin())] = true;
    }
  }
}

}  // namespace

ReplaySettings read_settings(IniFile& ini, const ReplayRequest& request) {
  ReplaySettings settings = read_all_but_plugins(ini, request);
  const std::vector<std::string> names = read_plugin_names(ini);
  const std::string scans = read_scans_choice(ini);
  std::map<std::string, std::shared_ptr<MappingPlugin>> made;
  const auto make = [&](const std::string& name) {
    auto& plugin = made[without_namespace(name)];
    if (!plugin) plugin = make_plugin(name, ini);
    return plugin;
  };
  const bool automatic = is_auto(names);
  if (!automatic) {
    for (const std::string& name : names) settings.plugins.push_back(make(name));
  }
  for (const std::string& name : registered_plugins()) {
    if (ini.has_section(name)) make(name);
  }
  ini.reject_unknown();
  if (settings.robots.front().rawlog.empty()) {
    ini.section("log").fail("rawlog", "names no log, and neither does the command line");
  }
  for (const RobotSettings& robot : settings.robots) {
    if (is_standard_input(robot.rawlog)) reject_second_reading(request, robot.source, automatic);
  }
  const LogContents contents =
      read_logs(settings, automatic || fix_source_of(settings.plugins) != nullptr);
  if (automatic) {
    settings.chosen = choose_plugins(contents);
    for (const std::string& name : settings.chosen) settings.plugins.push_back(make(name));
  }
  for (const auto& plugin : settings.plugins) {
    const auto classes = plugin->observation_classes();
    for (RobotSettings& robot : settings.robots) {
      auto& asked = robot.source.reader.request.classes;
      asked.insert(asked.end(), classes.begin(), classes.end());
    }
  }
  measure_receivers(settings);
  space_keyframes(settings);
  settings.keeps_scans = keeps_scans(scans, settings);
  choose_plugins_of_robots(ini, automatic ? settings.chosen : names, settings);
  return settings;
}

ReplayRequest with_chosen_plugins(ReplayRequest request, const ReplaySettings& settings) {
  if (!settings.chosen.empty()) {
    request.settings.push_back(fmt::format("plugins.classes={}", fmt::join(settings.chosen, " ")));
  }
  const bool hidden =
      !settings.robots.empty() &&
      std::all_of(settings.robots.begin(), settings.robots.end(),
                  [](const auto& robot) { return robot.source.correction.hides_ids; });
  if (hidden) request.settings.emplace_back("sensor.ids=none");
  return request;
}

std::unique_ptr<IniFile> open_config(const ReplayRequest& request) {
  if (request.config.empty()) return std::make_unique<IniFile>("", "(defaults)");
  return std::make_unique<IniFile>(std::filesystem::path(request.config));
}

std::string config_text(const ReplayRequest& request) {
  const std::unique_ptr<IniFile> ini = open_config(request);
  read_all_but_plugins(*ini, request);
  std::vector<std::string> names = read_plugin_names(*ini);
  read_scans_choice(*ini);
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
