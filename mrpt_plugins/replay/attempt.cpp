// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/detail/attempt.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/bridge/detail/standard_input.h"
#include "mrpt_plugins/evaluation/mode_truth.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/output/sparsity.h"
#include "mrpt_plugins/replay/detail/judgement.h"
#include "mrpt_plugins/replay/detail/map_place.h"
#include "mrpt_plugins/replay/detail/movie.h"
#include "mrpt_plugins/replay/detail/result_files.h"
#include "mrpt_plugins/replay/detail/run_report.h"
#include "mrpt_plugins/replay/detail/run_summary.h"
#include "mrpt_plugins/replay/detail/scan_outputs.h"
#include "mrpt_plugins/replay/detail/team.h"
#include "mrpt_plugins/replay/detail/truth.h"
#include "mrpt_plugins/replay/settings.h"

namespace hybrid {
namespace {

using Plugins = std::vector<std::shared_ptr<MappingPlugin>>;

std::size_t count_keyframes(const ReplaySettings& settings) {
  LogMerge logs = open_logs(settings);
  std::size_t count = 0;
  while (logs.next()) {
    throw_if_interrupted();
    ++count;
  }
  return count;
}

/// The pictures of the growing map that are asked for, or none.
Movie make_movie(const ReplayRequest& request, const ReplaySettings& settings) {
  if (request.frames <= 0) return {0, 0};
  return {request.frames, count_keyframes(settings)};
}

/// How a replay ended.
struct Ending {
  BackendReport last;
  int signal = 0;  ///< that stopped it with keyframes left; 0: none did
};

/// The next keyframe; nothing at the end, or with a signal that asks to stop.
std::optional<Keyframe> next_keyframe(LogMerge& source, int& signal) {
  try {
    std::optional<Keyframe> keyframe = source.next();
    if (keyframe) signal = interrupted();
    return signal == 0 ? keyframe : std::nullopt;
  } catch (const Interrupted& e) {
    signal = e.signal();
    return std::nullopt;
  }
}

/// Feeds the log to the mapper, until the program is asked to stop, and solves to convergence.
Ending map_log(LogMerge& source, Mapper& mapper, MapPlace& place, Team& team,
               const std::function<void(const ReplayProgress&)>& progress, Movie& movie,
               RunReport& report, ScanOutputs& scans) {
  int signal = 0;
  std::size_t keyframes = 0;
  while (const auto keyframe = next_keyframe(source, signal)) {
    const StepRecord& step = mapper.add(*keyframe);
    team.added(keyframe->robot, mapper);
    place.added(mapper);
    scans.added(step, *keyframe);
    ++keyframes;
    std::string line = report.watch(mapper, step, *keyframe);
    if (progress) {
      progress(
          {source.progress(), keyframes, step.landmarks, step.objective_after, std::move(line)});
    }
    if (movie.size() > 0) movie.watch(keyframes, mapper);
  }
  if (keyframes == 0) {
    throw_if_interrupted();
    throw Error(source.message().empty() ? "the log holds no frame to map" : source.message());
  }
  if (signal != 0) place.pause(mapper);
  return {mapper.finish(), signal};
}

/// Says when the place of a single robot was known, and which robots were left out.
void tell(const Team& team, Summary& summary) {
  if (team.is_in_map()) summary.localized_at = team.known_at(0);
  if (team.message().empty()) return;
  if (summary.status == "ok") summary.status = "partial";
  summary.message += (summary.message.empty() ? "" : "; ") + team.message();
}

/// What only the command line asks for: matrices, frames. Returns warnings.
std::vector<std::string> write_extras(const ReplayRequest& request, const OutputDirectory& out,
                                      const MapResult& result, const GroundTruth& truth,
                                      const Mapper& mapper, Movie& movie) {
  std::vector<std::string> warnings;
  if (request.sparsity) {
    const Backend& backend = mapper.backend();
    warnings = write_sparsity(out, backend.graph(), backend.assignment(),
                              backend.elimination_order(), result.title);
  }
  if (movie.size() == 0) return warnings;
  movie.finish(result);
  movie.write_frames(out, truth);
  return warnings;
}

/// How well slip was found, where the true modes are known.
std::optional<ModeScore> mode_score(const std::string& file, const RobotPart& part) {
  if (file.empty()) return std::nullopt;
  const std::vector<int> truth = read_true_modes(file);
  if (part.result.mode_names.empty()) return std::nullopt;
  return score_modes(part.result, part.log_rows, truth);
}

bool tells_paths(const std::vector<Truth>& truths) {
  return std::any_of(truths.begin(), truths.end(),
                     [](const Truth& truth) { return !truth.get().path.empty(); });
}

bool is_empty(const TruthSummary& truth) {
  return !truth.trajectory && !truth.landmarks && !truth.associations && !truth.modes;
}

/// What the summary says of each of several robots.
std::vector<RobotSummary> robot_summaries(const ReplaySettings& settings,
                                          const std::vector<RobotPart>& parts,
                                          const std::vector<Truth>& truths, const Team& team) {
  std::vector<RobotSummary> out;
  for (std::size_t i = 0; i < parts.size() && !parts.front().name.empty(); ++i) {
    RobotSummary robot{parts[i].name, settings.robots[i].rawlog, parts[i].log_rows.size(), {}, {}};
    if (team.is_in_map()) robot.localized_at = team.known_at(i);
    TruthSummary truth = compare_path(truths[i], parts[i]);
    truth.modes = mode_score(settings.robots[i].truth_modes, parts[i]);
    if (!is_empty(truth)) robot.truth = std::move(truth);
    out.push_back(std::move(robot));
  }
  return out;
}

/// All files that a replay reads.
Provenance provenance(const ReplayRequest& request, const ReplaySettings& settings,
                      const IniFile& ini) {
  Provenance provenance = request.provenance;
  provenance.configuration = ini.settings();
  const auto add_log = [&provenance](const RobotSettings& robot) {
    if (is_standard_input(robot.rawlog)) {
      provenance.inputs.push_back({robot.rawlog, "", ""});
    } else {
      provenance.add_input(robot.rawlog);
    }
  };
  const RobotSettings& first = settings.robots.front();
  add_log(first);
  for (const std::string& path :
       {request.config, first.truth_path, settings.truth_map, settings.truth_movers,
        first.truth_associations, first.truth_modes}) {
    provenance.add_input(path);
  }
  for (std::size_t i = 1; i < settings.robots.size(); ++i) {
    const RobotSettings& robot = settings.robots[i];
    add_log(robot);
    for (const std::string& path :
         {robot.truth_path, robot.truth_associations, robot.truth_modes}) {
      provenance.add_input(path);
    }
  }
  for (const std::string& path : request.plugin_libraries) provenance.add_input(path);
  return provenance;
}

/// Those that errors of a replay may be about.
std::vector<std::string> files_of(const ReplaySettings& settings) {
  std::vector<std::string> files;
  for (const RobotSettings& robot : settings.robots) files.push_back(shown_path(robot.rawlog));
  files.push_back(settings.map.file);
  return files;
}

/// Compares the result with what is known to be true, of all robots together and of each.
void compare_with_truth(const ReplaySettings& settings, const std::vector<RobotPart>& parts,
                        const std::vector<Truth>& truths, const Mapper& mapper, const Team& team,
                        Summary& summary) {
  TruthSummary truth = compare(truths, parts, mapper, settings.match_radius);
  if (parts.size() == 1) {
    truth.modes = mode_score(settings.robots.front().truth_modes, parts.front());
  }
  if (!is_empty(truth)) summary.truth = std::move(truth);
  summary.robots = robot_summaries(settings, parts, truths, team);
}

/// What is odd in the files that a replay reads, apart from the logs.
std::vector<std::string> input_warnings(const IniFile& ini, const std::vector<Truth>& truths,
                                        const std::vector<RobotPart>& parts,
                                        const Provenance& provenance) {
  std::vector<std::string> out = ini.warnings();
  for (std::size_t i = 0; i < truths.size(); ++i) {
    for (std::string& odd : truths[i].warnings(parts[i])) out.push_back(std::move(odd));
  }
  for (const Provenance::Input& input : provenance.inputs) {
    if (!input.warning.empty()) out.push_back(input.path + ": " + input.warning);
  }
  return out;
}

/// Writes map and trajectories; returns warnings.
std::vector<std::string> write_estimates(const OutputDirectory& out, const MapResult& result,
                                         const std::vector<RobotPart>& parts,
                                         const std::vector<Truth>& truths, const Mapper& mapper,
                                         const ScanOutputs& scans, bool with_covariances) {
  std::vector<std::string> warnings = write_map(out, result, mapper.backend());
  for (std::string& warning : scans.write(out, result, mapper)) {
    warnings.push_back(std::move(warning));
  }
  std::vector<Trajectory> paths;
  for (std::size_t i = 0; i < parts.size(); ++i) paths.push_back(scans.path(parts[i], result, i));
  write_paths(out, parts, paths, truths);
  if (with_covariances) write_covariances(out, parts);
  return warnings;
}

/// Whether noise, clock and mounting are to be measured where the map is bad: logs can be read
/// twice, and nothing but OUT holds what was mapped.
bool may_measure(const ReplayRequest& request, const ReplaySettings& settings) {
  if (request.stream || request.resume || !settings.map.file.empty()) return false;
  return std::all_of(
      settings.robots.begin(), settings.robots.end(), [](const RobotSettings& robot) {
        std::error_code unknown;
        return robot.source.noise == NoiseSource::kAuto && !is_standard_input(robot.rawlog) &&
               std::filesystem::is_regular_file(robot.rawlog, unknown);
      });
}

/// Whether nothing but noise is corrected.
bool is_of_noise(const LogCorrection& correction) {
  return !correction.hides_ids &&
         std::all_of(correction.sensors.begin(), correction.sensors.end(), [](const auto& sensor) {
           const SensorCorrection& s = sensor.second;
           return !s.mirrored && s.yaw == 0 && s.delay == 0;
         });
}

/// Whether nothing measured is used in place of what the logs state; or nothing but noise.
bool takes_at_word(const ReplaySettings& settings, bool but_for_noise) {
  return std::all_of(settings.robots.begin(), settings.robots.end(), [&](const auto& robot) {
    const LogCorrection& correction = robot.source.correction;
    return but_for_noise ? is_of_noise(correction) : correction.is_none();
  });
}

/// Whether a map is the one to write.
bool is_wanted(const Conditions& conditions, const Health& health, int signal) {
  return conditions.other == nullptr ||
         (signal == 0 && conditions.better(health, *conditions.other));
}

/// Adds to a summary what was measured of the log, and what became of the map and of the robots.
void tell_all(const ReplaySettings& settings, const MapPlace& place, const Team& team,
              MapResult& result, Summary& summary) {
  tell_findings(settings, summary);
  place.tell(result, summary);
  tell(team, summary);
}

/// Pictures, and what the request asks for besides; returns warnings.
std::vector<std::string> draw(const ReplayRequest& request, OutputDirectory& out,
                              const MapResult& result, const std::vector<RobotPart>& parts,
                              const std::vector<Truth>& truths, const Mapper& mapper,
                              Movie& movie) {
  const GroundTruth truth = joint_truth(truths);
  std::vector<std::string> warnings;
  if (request.pictures) {
    warnings = write_pictures(out, request.picture_format, result, truth);
    write_error_plots(out, request.picture_format, parts, truths);
  }
  for (std::string& warning : write_extras(request, out, result, truth, mapper, movie)) {
    warnings.push_back(std::move(warning));
  }
  return warnings;
}

/// Shows the result together with the map file, if the run was not interrupted; returns warnings.
std::vector<std::string> publish_with_map(const Summary& summary, OutputDirectory& out,
                                          MapPlace& place, const Mapper& mapper,
                                          const MapResult& result, const ScanOutputs& scans,
                                          int signal) {
  std::vector<std::string> told;
  const auto show = [&] { told = out.publish(summary_json(summary)); };
  std::vector<MapLocalMap> local_maps;
  if (place.writes()) local_maps = scans.local_maps(result, mapper);
  signal != 0 ? show() : place.finish(mapper, result, local_maps, show);
  return told;
}

}  // namespace

Attempt attempt(const ReplayRequest& request, const Watchers& watchers,
                std::chrono::steady_clock::time_point start, const Conditions& conditions) {
  const std::unique_ptr<IniFile> ini_file = open_config(request);
  IniFile& ini = *ini_file;
  ReplaySettings settings = read_settings(ini, request);
  if (conditions.corrected && takes_at_word(settings, conditions.aligned)) return {{}, false};
  std::vector<Truth> truths = read_truths(settings);
  OutputDirectory out(request.output);
  LogMerge source = open_logs(settings);
  const bool is_3d = source.is_3d();
  MapPlace place(
      request, settings, [&] { return provenance(request, settings, ini); }, is_3d);
  Team team(request, settings, place.map(), is_3d);
  if (!team.message().empty()) {  // robots were left out
    truths = read_truths(settings);
    source = open_logs(settings);
  }
  Movie movie = make_movie(request, settings);
  const Plugins plugins = settings.plugins;
  Mapper mapper = make_mapper(settings, is_3d);
  place.enter(mapper, team.is_in_map());
  RunReport report(request, settings, out);
  ScanOutputs scans(settings.keeps_scans, plugins);
  if (team.is_in_map()) scans.adopt(place.map(), settings.robots);
  report.begin(mapper, settings.title);
  const std::vector<std::string> files = files_of(settings);
  const auto [last, signal] = about(files, [&] {
    return map_log(source, mapper, place, team, watchers.progress, movie, report, scans);
  });

  MapResult result = about(files, [&] { return mapper.result(); });
  result.title = settings.title;
  scans.finish(result);
  report.finish(mapper, result, last.objective_after);
  Attempt made;
  made.outcome = {summarize(source, plugins, mapper, last, result, signal), out.folder(), signal};
  made.may_measure = signal == 0 && may_measure(request, settings);
  Summary& summary = made.outcome.summary;
  summary.chosen_plugins = settings.chosen;
  summary.health = judge_run(request, settings, source.repeated_stamps(), mapper, result);
  made.is_written = is_wanted(conditions, summary.health, signal);
  if (!made.is_written) return made;
  tell_all(settings, place, team, result, summary);
  const std::vector<RobotPart> parts =
      parts_of(result, mapper, tells_paths(truths) || place.localizes());
  adapt(truths, parts);
  compare_with_truth(settings, parts, truths, mapper, team, summary);
  summary.provenance = provenance(request, settings, ini);
  warn(summary, input_warnings(ini, truths, parts, summary.provenance));
  warn(summary, write_estimates(out, result, parts, truths, mapper, scans, place.localizes()));
  summary.total_s = seconds_since(start);  // without pictures
  warn(summary, draw(request, out, result, parts, truths, mapper, movie));
  report.write(result, parts, truths, scans.drawn(), summary_json(summary));
  const std::vector<std::string> told =
      publish_with_map(summary, out, place, mapper, result, scans, signal);
  if (watchers.published) watchers.published(made.outcome);
  warn(summary, told);
  return made;
}

}  // namespace hybrid
