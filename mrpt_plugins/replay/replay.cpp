// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/replay/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/about_file.h"
#include "mrpt_plugins/bridge/detail/standard_input.h"
#include "mrpt_plugins/evaluation/mode_truth.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/mapping/plugin_choice.h"
#include "mrpt_plugins/output/sparsity.h"
#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/replay/detail/film.h"
#include "mrpt_plugins/replay/detail/judgement.h"
#include "mrpt_plugins/replay/detail/map_place.h"
#include "mrpt_plugins/replay/detail/movie.h"
#include "mrpt_plugins/replay/detail/result_files.h"
#include "mrpt_plugins/replay/detail/run_report.h"
#include "mrpt_plugins/replay/detail/scan_outputs.h"
#include "mrpt_plugins/replay/detail/team.h"
#include "mrpt_plugins/replay/detail/truth.h"
#include "mrpt_plugins/replay/settings.h"

namespace hybrid {
namespace {

using Plugins = std::vector<std::shared_ptr<MappingPlugin>>;
using Clock = std::chrono::steady_clock;

constexpr int kMostMeasurements = 3;  // of the noise, each with a map
constexpr double kAlike = 1.1;        // factor between badness of two maps that is by chance
constexpr double kMuchWorse = 1e9;
constexpr int kVideoFrames = 100;  // where --frames does not say

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
  const bool asked = request.frames > 0 || !request.video.empty();
  if (!asked) return {0, 0};
  return {request.frames > 0 ? request.frames : kVideoFrames, count_keyframes(settings)};
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

/// Whether something odd in a log was dropped, repaired or missing; the rest is for information.
bool is_loss(const std::string& what) {
  const auto has = [&](const char* word) { return what.find(word) != std::string::npos; };
  return has(" dropped: ") || has(" repaired: ") || has(" missing: a gap");
}

/// What of the log could not become part of the map, and why; "" where all could.
std::string refusals(const Mapper& mapper) {
  if (mapper.warnings().empty()) return "";
  std::size_t count = 0;
  for (const auto& [reason, times] : mapper.dropped()) {
    if (reason.find(" dropped: not ") != std::string::npos) count += times;
  }
  return fmt::format("left out as not usable {} time{}, first in {}", count, count == 1 ? "" : "s",
                     mapper.warnings().front());
}

/// Sets status and message; `signal` is what stopped the replay, or 0.
void set_status(const LogMerge& source, const Mapper& mapper, const MapResult& result, int signal,
                Summary& summary) {
  const std::string refused = refusals(mapper);
  if (signal != 0) {
    summary.status = "interrupted";
    summary.message = fmt::format("stopped by {} after {} keyframes", signal_name(signal),
                                  result.trajectory.size());
    if (const auto share = source.progress()) {
      summary.message += fmt::format(", {:.1f} % of the log", 100 * *share);
    }
  } else if (source.status() != LogStatus::kComplete) {
    summary.status = "partial";
    summary.message = source.message();
  } else if (result.landmarks.empty() && mapper.measurements() == 0 && refused.empty()) {
    summary.status = "empty";
    summary.message = "no landmark was mapped: " + why_nothing_mapped(summary.observations);
  } else if (!refused.empty()) {
    summary.status = "partial";
  }
  if (refused.empty()) return;
  summary.message += (summary.message.empty() ? "" : "; ") + refused;
}

void warn(Summary& summary, const std::vector<std::string>& more) {
  summary.warnings.insert(summary.warnings.end(), more.begin(), more.end());
}

Summary summarize(const LogMerge& source, const Plugins& plugins, const Mapper& mapper,
                  const BackendReport& last, const MapResult& result, int signal) {
  Summary summary;
  summary.observations = observation_uses(source.observations(), plugins);
  set_status(source, mapper, result, signal, summary);
  summary.mode = mapper.backend().mode();
  summary.keyframes = result.trajectory.size();
  summary.landmarks = result.landmarks.size();
  summary.movers = result.movers.size();
  summary.objective = last.objective_after;
  summary.cost = last.cost;
  summary.steps = step_statistics(result.steps);
  summary.plugins = plugin_statistics(result.steps);
  summary.statistics = mapper.statistics();
  summary.solver_s = summary.steps.total_s + last.seconds;
  summary.dropped = source.dropped();
  for (const auto& [reason, count] : mapper.dropped()) summary.dropped[reason] += count;
  for (const auto& [what, count] : source.warnings()) {
    if (is_loss(what)) {
      summary.dropped[what] += count;
      continue;
    }
    summary.warnings.push_back(count == 1 ? what : fmt::format("{} ({} times)", what, count));
  }
  warn(summary, mapper.warnings());
  warn(summary, last.warnings);
  summary.calibration = result.calibration;
  for (const int mode : result.motion_modes) {
    if (mode >= 0) ++summary.modes[result.mode_names[static_cast<std::size_t>(mode)]];
  }
  return summary;
}

/// Says when the place of a single robot was known, and which robots were left out.
void tell(const Team& team, Summary& summary) {
  if (team.is_in_map()) summary.localized_at = team.known_at(0);
  if (team.message().empty()) return;
  if (summary.status == "ok") summary.status = "partial";
  summary.message += (summary.message.empty() ? "" : "; ") + team.message();
}

/// What only the command line asks for: matrices, frames, video. Returns warnings.
std::vector<std::string> write_extras(const ReplayRequest& request, const OutputDirectory& out,
                                      const MapResult& result, const GroundTruth& truth,
                                      const Mapper& mapper, Movie& movie, const Film& film) {
  std::vector<std::string> warnings;
  if (request.sparsity) {
    const Backend& backend = mapper.backend();
    warnings = write_sparsity(out, backend.graph(), backend.assignment(),
                              backend.elimination_order(), result.title);
  }
  if (movie.size() > 0) movie.finish(result);
  if (request.frames > 0) movie.write_frames(out, truth);
  if (!film.wanted()) return warnings;
  const std::string note = film.encode(movie.size(), [&](int i) { return movie.frame(i, truth); });
  if (!note.empty()) warnings.push_back(note);
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

/// Shows film and result, both or none; returns warnings.
std::vector<std::string> publish(const Summary& summary, OutputDirectory& out, Film& film) {
  film.commit();
  try {
    return out.publish(summary_json(summary));
  } catch (...) {
    film.undo();
    throw;
  }
}

/// What to tell of a replay while it runs.
struct Watchers {
  const std::function<void(const ReplayProgress&)>& progress;
  const std::function<void(const ReplayOutcome&)>& published;
};

/// One map of the logs, which was written unless it is no better than another.
struct Attempt {
  ReplayOutcome outcome;
  bool is_written = true;
  bool may_measure = false;  ///< the logs can be measured, and mapped again
};

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

/// Whether nothing measured is used in place of what the logs state.
bool takes_at_word(const ReplaySettings& settings) {
  return std::all_of(settings.robots.begin(), settings.robots.end(),
                     [](const RobotSettings& robot) { return robot.source.correction.is_none(); });
}

/// How far beyond its limits the value of a bad entry is, a factor; 0: it is not bad.
double badness(const HealthEntry& entry) {
  if (entry.verdict != HealthVerdict::kBad) return 0;
  if (entry.value < entry.least) return entry.value > 0 ? entry.least / entry.value : kMuchWorse;
  return entry.most > 0 ? entry.value / entry.most : kMuchWorse;
}

double badness(const Health& health, const std::string& name) {
  double worst = 0;
  for (const HealthEntry& entry : health) {
    if (entry.name == name) worst = std::max(worst, badness(entry));
  }
  return worst;
}

/// Whether a map says less against itself than another, and nothing worse.
bool is_better(const Health& a, const Health& b) {
  const auto bad = [](const HealthEntry& entry) { return badness(entry) > 0; };
  const bool is_worse = std::any_of(a.begin(), a.end(), [&](const HealthEntry& entry) {
    return badness(entry) > kAlike * badness(b, entry.name);
  });
  return !is_worse &&
         std::count_if(a.begin(), a.end(), bad) < std::count_if(b.begin(), b.end(), bad);
}

/// When a map of the logs is not the one to write.
struct Conditions {
  const Health* other = nullptr;  ///< of a map that this one has to be better than
  bool corrected = false;         ///< it is made only if something of the logs is corrected
};

/// Maps the logs, and writes the result where the conditions hold.
Attempt attempt(const ReplayRequest& request, const Watchers& watchers, Clock::time_point start,
                const Conditions& conditions) {
  const std::unique_ptr<IniFile> ini_file = open_config(request);
  IniFile& ini = *ini_file;
  ReplaySettings settings = read_settings(ini, request);
  if (conditions.corrected && takes_at_word(settings)) return {{}, false};
  std::vector<Truth> truths = read_truths(settings);
  OutputDirectory out(request.output);
  Film film(request.video, out);
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
  summary.health = judge_run(request, settings, mapper, result);
  made.is_written =
      conditions.other == nullptr || (signal == 0 && is_better(summary.health, *conditions.other));
  if (!made.is_written) return made;
  tell_findings(settings, summary);
  place.tell(result, summary);
  tell(team, summary);
  const std::vector<RobotPart> parts =
      parts_of(result, mapper, tells_paths(truths) || place.localizes());
  adapt(truths, parts);
  compare_with_truth(settings, parts, truths, mapper, team, summary);
  summary.provenance = provenance(request, settings, ini);
  warn(summary, input_warnings(ini, truths, parts, summary.provenance));

  warn(summary, write_estimates(out, result, parts, truths, mapper, scans, place.localizes()));
  summary.total_s = seconds_since(start);  // without pictures
  const GroundTruth truth = joint_truth(truths);
  if (request.pictures) {
    warn(summary, write_pictures(out, result, truth));
    write_error_plots(out, parts, truths);
  }
  warn(summary, write_extras(request, out, result, truth, mapper, movie, film));
  report.write(result, parts, truths, summary_json(summary));
  std::vector<std::string> told;
  const auto show = [&] { told = publish(summary, out, film); };
  signal != 0 ? show() : place.finish(mapper, result, show);
  if (watchers.published) watchers.published(made.outcome);
  warn(summary, told);
  return made;
}

/// The number that section.key of a configuration is; 1 where it has none.
double setting(const IniFile::Settings& configuration, const std::string& name) {
  for (const auto& [section, keys] : configuration) {
    for (const auto& [key, value] : keys) {
      if (section + "." + key == name) return std::stod(value);
    }
  }
  return 1;
}

/// Multiplies the factors of noise by what a bad map says of them; returns whether any changed.
bool scale_noise(const Health& health, const IniFile::Settings& configuration,
                 std::map<std::string, double>& factors) {
  bool changed = false;
  for (const HealthEntry& entry : health) {
    if (entry.verdict != HealthVerdict::kBad || entry.scale.empty()) continue;
    factors.try_emplace(entry.scale, setting(configuration, entry.scale)).first->second *=
        entry.value;
    changed = true;
  }
  return changed;
}

/// Maps logs whose map is bad again, with what they and that map tell of their noise, and takes an
/// outcome that is better.
void map_as_measured(const ReplayRequest& request, const Watchers& watchers,
                     Clock::time_point start, ReplayOutcome& outcome) {
  Health health = outcome.summary.health;
  const IniFile::Settings configuration = outcome.summary.provenance.configuration;
  std::map<std::string, double> factors;
  for (int round = 0; round < kMostMeasurements; ++round) {
    const bool scaled = scale_noise(health, configuration, factors);
    if (worst(health) != HealthVerdict::kBad || (round > 0 && !scaled)) return;
    ReplayRequest measured = request;
    measured.settings.emplace_back("sensor.noise=measured");
    for (const auto& [key, factor] : factors) {
      measured.settings.push_back(fmt::format("{}={}", key, factor));
    }
    Attempt next = attempt(measured, watchers, start, {&outcome.summary.health, !scaled});
    health = next.outcome.summary.health;
    if (next.is_written) {
      outcome = std::move(next.outcome);
    } else if (next.outcome.signal != 0) {
      outcome.signal = next.outcome.signal;
      return;
    }
  }
}

}  // namespace

ReplayOutcome replay(const ReplayRequest& request,
                     const std::function<void(const ReplayProgress&)>& progress,
                     const std::function<void(const ReplayOutcome&)>& published) {
  const auto start = Clock::now();
  const Watchers watchers{progress, published};
  Attempt first = attempt(request, watchers, start, {});
  if (!first.may_measure) return std::move(first.outcome);
  try {
    map_as_measured(request, watchers, start, first.outcome);
  } catch (const Interrupted& e) {
    first.outcome.signal = e.signal();
  } catch (const Error& e) {
    first.outcome.summary.warnings.push_back(
        fmt::format("the log was not mapped again with its noise measured: {}", e.what()));
  }
  return std::move(first.outcome);
}

}  // namespace hybrid
