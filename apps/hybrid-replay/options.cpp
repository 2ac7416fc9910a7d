// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-replay/options.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "apps/command_line.h"

namespace hybrid {
namespace {

constexpr const char* kAbout =
    "Replays an MRPT rawlog: corrects the trajectory of the robot and maps the landmarks it saw,\n"
    "with their classes, by inference over continuous and discrete variables together.\n";

constexpr const char* kFooter =
    "\nWritten to OUT: trajectory.tum, trajectory_dead_reckoning.tum, landmarks.csv, "
    "landmarks.json,\n"
    "graph.g2o, steps.csv, summary.json, map.png, steps.png; with a "
    "true\n"
    "path trajectory_truth.tum, error.png; where things move, movers.csv; where asked, "
    "report.html, events.jsonl\n"
    "and frames/; of several robots, what is about a path in a folder of the robot's name.\n"
    "They replace the result that OUT holds; files of others stay. A map\n"
    "file is written besides, docs/maps.md.\n"
    "\nExit code: 0 all well; 1 failure, nothing written; 2 the rawlog is damaged: everything up "
    "to\n"
    "the damage was used and written, and summary.json has status \"partial\", or no landmark "
    "was\n"
    "mapped: \"empty\", or with --strict the run says of itself that it is wrong; 129, 130, 143 "
    "stopped by SIGHUP, SIGINT (Ctrl-C), SIGTERM: what was "
    "mapped\n"
    "so far was written, status \"interrupted\". A second signal ends at once, with nothing "
    "written.\n"
    "\nExamples: hybrid-replay robot.rawlog -o out\n"
    "          hybrid-replay -c config/kf_slam_demo.ini -o out\n"
    "          zcat robot.rawlog | hybrid-replay -c my.ini --rawlog - --stream";

/// NAME and FILE of NAME=FILE; no name where that is a file as a whole.
std::pair<std::string, std::string> named(const std::string& text) {
  const std::size_t equals = text.find('=');
  std::error_code unknown;
  if (equals == std::string::npos || std::filesystem::exists(text, unknown)) return {"", text};
  return {text.substr(0, equals), text.substr(equals + 1)};
}

/// One log, or those of several robots.
void take_robots(const std::vector<std::string>& logs, const std::vector<std::string>& truth_paths,
                 ReplayRequest& request) {
  const bool one = logs.size() == 1 && named(logs.front()).first.empty();
  if (one) request.rawlog = logs.front();
  for (std::size_t i = 0; i < logs.size() && !one; ++i) {
    auto [name, file] = named(logs[i]);
    if (name.empty()) name = std::filesystem::path(file).stem().string();
    const bool twice = std::any_of(request.robots.begin(), request.robots.end(),
                                   [&n = name](const RequestedRobot& r) { return r.name == n; });
    if (twice) {
      throw CLI::ValidationError(
          "--rawlog", "two logs are of robot " + name + "; NAME=FILE gives each a name of its own");
    }
    request.robots.push_back({name, file, ""});
  }
  for (const std::string& text : truth_paths) {
    const auto [name, file] = named(text);
    if (name.empty() && truth_paths.size() == 1 && request.robots.empty()) {
      request.truth_path = file;
      continue;
    }
    if (name.empty())
      throw CLI::ValidationError("--truth-path", text + ": of which robot? NAME=FILE");
    const auto it = std::find_if(request.robots.begin(), request.robots.end(),
                                 [&n = name](const RequestedRobot& r) { return r.name == n; });
    if (it == request.robots.end()) {
      request.robots.push_back({name, "", file});
    } else {
      it->truth_path = file;
    }
  }
}

/// Plugins, settings and the map file.
void add_plugins_and_map(CLI::App& app, ReplayRequest& request) {
  app.add_option("-p,--plugins", request.plugin_libraries,
                 "libraries with further plugins or observation classes, separated by commas")
      ->type_name("LIB.so")
      ->delimiter(',')
      ->allow_extra_args(false);
  add_settings(app, request.settings);
  app.add_option("--map", request.map,
                 "map file that the log makes, extends or is localised in, instead of [map] file")
      ->type_name("F.hmap")
      ->check(&fault_of_file_name);
  app.add_option("--map-mode", request.map_mode, "what the log does to it, instead of [map] mode")
      ->type_name("MODE")
      ->check(CLI::IsMember({"auto", "build", "extend", "localize"}));
  app.add_flag("--resume", request.resume,
               "go on with the session of the map file that was interrupted");
}

/// The folder of the result and what is written there.
void add_outputs(CLI::App& app, ReplayRequest& request) {
  add_output_folder(app, request.output);
  app.add_flag("!--no-pictures", request.pictures, "do not draw map.png, steps.png and error.png");
  add_picture_format(app, request.picture_format);
  app.add_option("--frames", request.frames,
                 "write the growing map as so many pictures, frames/frame_0001.png and so on")
      ->type_name("N")
      ->check(CLI::Range(1, 9999));
  app.add_option_function<std::string>(
         "--video",
         [](const std::string&) {
           throw CLI::ValidationError(
               "--video",
               "videos are no longer written; --frames 100 draws their pictures, and ffmpeg joins "
               "them: ffmpeg -framerate 10 -i OUT/frames/frame_%04d.png -pix_fmt yuv420p map.mp4");
         })
      ->group("");  // not in --help
  app.add_flag("--report", request.report,
               "write report.html, a page to look into the run with a browser, and events.jsonl");
  app.add_flag("--events", request.events,
               "write events.jsonl: why each sighting was given to its landmark, what flipped, "
               "merged and closed, the objective after every half-step");
  app.add_flag("--stream", request.stream,
               "write every keyframe to standard output when it is mapped, a line of JSON each; "
               "what else is said goes to standard error");
  add_retired_flag(app, "--sparsity");
}

}  // namespace

std::optional<Options> parse_options(int argc, char** argv, int& exit_code) {
  Options options;
  CLI::App app(kAbout, "hybrid-replay");
  app.footer(kFooter);
  app.add_option("-c,--config", options.request.config,
                 "INI file with all settings; see --print-config")
      ->type_name("INI");
  std::vector<std::string> logs, truth_paths;
  app.add_option("--rawlog,LOG", logs,
                 "the log, instead of [log] rawlog, whose truth is then left out; - is standard "
                 "input, mapped as it comes; without -c the log itself chooses the plugins. "
                 "Several logs, or NAME=FILE, are those of several "
                 "robots in one map, each a section [robot.NAME]; the name of a file is that of "
                 "its robot")
      ->type_name("FILE");
  app.add_option("--truth-path", truth_paths,
                 "true path of the robot, instead of [log] truth_path: MRPT's "
                 "_ground_truth_robot_path.txt, TUM (.tum) or `time x y z` (.xyz); NAME=FILE for "
                 "each of several")
      ->type_name("FILE")
      ->allow_extra_args(false);
  app.add_option("--truth-map", options.request.truth_map,
                 "true landmarks, instead of [log] truth_map: MRPT's _ground_truth.txt")
      ->type_name("FILE");
  add_plugins_and_map(app, options.request);
  add_outputs(app, options.request);
  app.add_flag("--cross-check", options.request.cross_check,
               "map every other detection apart from the rest, too, and compare: takes twice the "
               "time more; the result is under health in summary.json");
  app.add_flag("--strict", options.strict,
               "exit with 2 where the run says of itself that it is wrong: a bad verdict under "
               "health in summary.json");
  app.add_flag("--print-config", options.print_config,
               "print every section and key with its meaning, default and the value in effect");
  app.callback([&] {
    take_robots(logs, truth_paths, options.request);
    if (options.request.cross_check && std::find(logs.begin(), logs.end(), "-") != logs.end()) {
      throw CLI::ValidationError("--cross-check", "reads the log three times and needs a file");
    }
    if (options.request.config.empty() && logs.empty() && !options.print_config) {
      throw CLI::RequiredError("a log or -c INI (try -c config/kf_slam_demo.ini, or --help)");
    }
  });
  if (!parse_command_line(app, argc, argv, exit_code)) return std::nullopt;
  options.request.provenance = provenance_of(argc, argv);
  return options;
}

}  // namespace hybrid
