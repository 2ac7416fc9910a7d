// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/job/detail/attempt.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/standard_input.h"
#include "mrpt_plugins/evaluation/mode_truth.h"
#include "mrpt_plugins/job/detail/agreement_so_far.h"
#include "mrpt_plugins/job/detail/cloud_outputs.h"
#include "mrpt_plugins/job/detail/movie.h"
#include "mrpt_plugins/job/detail/result_files.h"
#include "mrpt_plugins/job/detail/run_report.h"
#include "mrpt_plugins/job/detail/scan_outputs.h"
#include "mrpt_plugins/job/run_summary.h"
#include "mrpt_plugins/report/photographs.h"
#include "mrpt_plugins/session/session.h"
#include "mrpt_plugins/session/truth.h"

namespace hybrid {
namespace {

/// Says when the place of a single robot was known, and which robots were left out.
void tell(const Team& team, Summary& summary) {
  if (team.is_in_map()) summary.localized_at = team.known_at(0);
  if (team.message().empty()) return;
  if (summary.status == "ok") summary.status = "partial";
  summary.message += (summary.message.empty() ? "" : "; ") + team.message();
}

/// How well slip was found, where the true modes are known.
std::optional<ModeScore> mode_score(const std::string& file, const RobotPart& part) {
  if (file.empty()) return std::nullopt;
  const std::vector<int> truth = read_true_modes(file);
  if (part.result.mode_names.empty()) return std::nullopt;
  return score_modes(part.result, part.log_rows, truth);
}

/// How well it was told what fixes are, where that is known.
std::optional<FixScore> fix_score(const RobotSettings& robot, const RobotPart& part) {
  if (robot.truth_fixes.empty()) return std::nullopt;
  std::vector<TrueFix> truth = read_true_fixes(robot.truth_fixes);
  for (TrueFix& row : truth) row.time += robot.source.reader.clock_offset;
  std::vector<FixEstimate> own;
  const std::vector<std::size_t>& rows = part.rows_by_keyframe;
  for (const FixEstimate& fix : part.result.fixes) {
    const bool is_own = fix.keyframe < rows.size() && rows[fix.keyframe] != ~std::size_t{0};
    if (is_own) own.push_back(fix);
  }
  if (own.empty()) return std::nullopt;
  if (truth.back().time < own.front().time || truth.front().time > own.back().time) {
    throw Error(fmt::format(
        "{}: its rows are of {:.3f} to {:.3f} s, the fixes of the log of {:.3f} to {:.3f} s: give "
        "the truth of this log, whose times are of its clock",
        robot.truth_fixes, truth.front().time, truth.back().time, own.front().time,
        own.back().time));
  }
  return score_fixes(std::move(own), truth);
}

bool tells_paths(const std::vector<Truth>& truths) {
  return std::any_of(truths.begin(), truths.end(),
                     [](const Truth& truth) { return !truth.get().path.empty(); });
}

bool is_empty(const TruthSummary& truth) {
  return !truth.trajectory && !truth.landmarks && !truth.associations && !truth.modes &&
         !truth.fixes;
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
    truth.fixes = fix_score(settings.robots[i], parts[i]);
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
        first.truth_associations, first.truth_modes, first.truth_fixes}) {
    provenance.add_input(path);
  }
  for (std::size_t i = 1; i < settings.robots.size(); ++i) {
    const RobotSettings& robot = settings.robots[i];
    add_log(robot);
    for (const std::string& path :
         {robot.truth_path, robot.truth_associations, robot.truth_modes, robot.truth_fixes}) {
      provenance.add_input(path);
    }
  }
  for (const std::string& path : request.plugin_libraries) provenance.add_input(path);
  return provenance;
}

/// Compares the result with what is known to be true, of all robots together and of each.
void compare_with_truth(const ReplaySettings& settings, const std::vector<RobotPart>& parts,
                        const std::vector<Truth>& truths, const Mapper& mapper, const Team& team,
                        Summary& summary) {
  TruthSummary truth = compare(truths, parts, mapper, settings.match_radius);
  if (parts.size() == 1) {
    truth.modes = mode_score(settings.robots.front().truth_modes, parts.front());
    truth.fixes = fix_score(settings.robots.front(), parts.front());
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

/// Whether the map says where on earth, or in which map, the robots are.
bool lies_somewhere(const Session& session, const MapResult& result) {
  return session.place().localizes() || result.datum;
}

/// Writes map and trajectories; returns warnings.
std::vector<std::string> write_estimates(const OutputDirectory& out, const MapResult& result,
                                         const std::vector<RobotPart>& parts,
                                         const std::vector<Truth>& truths, const Session& session,
                                         const ScanOutputs& scans) {
  const Mapper& mapper = session.mapper();
  std::vector<std::string> warnings = write_map(out, result, mapper.backend());
  for (std::string& warning : scans.write(out, result, mapper)) {
    warnings.push_back(std::move(warning));
  }
  for (std::string& warning : write_globe(out, result, session.place().origin())) {
    warnings.push_back(std::move(warning));
  }
  write_paths(out, parts, scans.paths(), result, truths);
  if (lies_somewhere(session, result)) write_covariances(out, parts);
  return warnings;
}

/// Asks for what the report shows of cameras.
void take_photographs(const ReplayRequest& request, ReplaySettings& settings) {
  if (!request.report) return;
  settings.robots.front().source.reader.request.classes.emplace_back(kPhotographClass);
}

/// What is done after each keyframe.
Session::Watch watch(Session& session, const Watchers& watchers, Movie& movie, RunReport& report,
                     ScanOutputs& scans, SensorArchives& measured) {
  return [&, so_far = AgreementSoFar(), keyframes = std::size_t{0}](
             const StepRecord& step, const Keyframe& keyframe) mutable {
    scans.added(step, keyframe);
    measured.detections.add(static_cast<std::size_t>(step.keyframe), keyframe);
    measured.clouds.add(static_cast<std::size_t>(step.keyframe), keyframe);
    ++keyframes;
    const Mapper& mapper = session.mapper();
    const auto agreement =
        report.has_lines() ? so_far.at(step.time, scans, measured, mapper) : std::nullopt;
    std::string line = report.watch(session.mapper(), step, keyframe, agreement);
    if (watchers.progress) {
      watchers.progress({session.source().progress(), keyframes, step.landmarks,
                         step.objective_after, std::move(line)});
    }
    if (movie.size() > 0) movie.watch(keyframes, mapper, scans.paths());
  };
}

/// The pictures that the request asks for.
void draw(const ReplayRequest& request, OutputDirectory& out, const MapResult& result,
          const std::vector<RobotPart>& parts, const std::vector<Truth>& truths, Movie& movie) {
  const GroundTruth truth = joint_truth(truths);
  if (request.pictures) {
    write_pictures(out, request.picture_format, result, truth);
    write_error_plots(out, request.picture_format, parts, truths);
  }
  if (movie.size() == 0) return;
  movie.finish(result);
  movie.write_frames(out, truth);
}

/// Whether the logs can be read once more, and nobody has seen events of the run.
bool may_repeat(const ReplayRequest& request, const ReplaySettings& settings) {
  return !request.stream &&
         std::none_of(settings.robots.begin(), settings.robots.end(),
                      [](const RobotSettings& r) { return is_standard_input(r.rawlog); });
}

/// A map and what it says about itself; it is written unless another is as good.
Attempt judged(const ReplayRequest& request, const ReplaySettings& settings, const Session& session,
               const MapResult& result, const Conditions& conditions, Health agreement) {
  const int signal = session.signal();
  Attempt made;
  made.request = request;
  made.work = session.mapper().work();
  made.outcome = {summarize(session, result), {}, signal};
  made.had_no_ids = std::any_of(settings.robots.begin(), settings.robots.end(),
                                [](const auto& r) { return r.source.correction.hides_ids; });
  made.measured_nothing = is_as_stated(settings, conditions.had_no_ids);
  made.may_measure = signal == 0 && may_measure(request, settings);
  Summary& summary = made.outcome.summary;
  summary.chosen_plugins = settings.chosen;
  summary.health = judge_run(request, settings, session.source(), session.mapper(), result,
                             std::move(agreement));
  if (conditions.other == nullptr) judge_findings(settings, summary.health);
  made.is_written = conditions.want(summary.health, signal);
  return made;
}

/// One that would not be another map.
Attempt left_out(const ReplayRequest& request, const ReplaySettings& settings,
                 const Conditions& conditions) {
  return {request, {}, false, false, false, is_as_stated(settings, conditions.had_no_ids)};
}

/// Maps the logs, unless that takes more than so much work.
bool map_within(double most_work, Session& session, const Session::Watch& watch) {
  session.mapper().limit_work(most_work);
  try {
    session.map(watch);
  } catch (const TooMuchWork&) {
    return false;
  }
  return true;
}

/// One attempt; where `doubt` has become the reason why the robots are not in the map file, nothing
/// was made, and it is to be made again with that.
Attempt attempt_once(const ReplayRequest& request, const Watchers& watchers,
                     std::chrono::steady_clock::time_point start, const Conditions& conditions,
                     std::string& doubt) {
  const std::unique_ptr<IniFile> ini = open_config(request);
  ReplaySettings settings = read_settings(*ini, request);
  if (!conditions.allow(settings)) return left_out(request, settings, conditions);
  take_photographs(request, settings);
  std::vector<Truth> truths = read_truths(settings);
  OutputDirectory out(request.output);
  Session session(
      request, settings, [&] { return provenance(request, settings, *ini); }, doubt);
  if (!session.team().message().empty()) truths = read_truths(settings);  // robots were left out
  Movie movie(request.frames, request.frames > 0 ? session.count_keyframes() : 0);
  session.begin();
  RunReport report(request, settings, out);
  ScanOutputs scans(settings.keeps_scans, session.mapper().is_3d(), session.plugins());
  SensorArchives measured;
  report.begin(session.mapper(), settings.title);
  if (!map_within(conditions.most_work, session,
                  watch(session, watchers, movie, report, scans, measured))) {
    return {request, {}, false, false, false, false, session.mapper().work()};
  }
  MapResult result = session.result();
  const Mapper& mapper = session.mapper();
  scans.finish(session.source(), result);
  const PlacedViews views(scans, measured, mapper, result.trajectory);
  const Agreement with_map = session.agreement(views.scans, views.clouds, views.reach,
                                               measured.detections, result.trajectory);
  if (const std::string found = session.doubt(with_map, views.any()); !found.empty()) {
    session.give_up_place(found);
    if (may_repeat(request, settings)) {
      doubt = found;
      return {};
    }
  }
  scans.draw(result, session.known());
  report.finish(session.mapper(), result, session.last().objective_after);
  Attempt made = judged(request, settings, session, result, conditions,
                        agreements(measured, views, with_map, mapper, result.trajectory));
  made.outcome.folder = out.folder();
  Summary& summary = made.outcome.summary;
  if (!made.is_written) return made;
  tell_findings(settings, summary);
  session.place().tell(result, summary);
  tell(session.team(), summary);
  const std::vector<RobotPart> parts =
      parts_of(result, mapper, tells_paths(truths) || lies_somewhere(session, result));
  adapt(truths, parts);
  compare_with_truth(settings, parts, truths, mapper, session.team(), summary);
  summary.provenance = provenance(request, settings, *ini);
  warn(summary, input_warnings(*ini, truths, parts, summary.provenance));
  warn(summary, write_estimates(out, result, parts, truths, session, scans));
  summary.total_s = seconds_since(start);  // without pictures
  draw(request, out, result, parts, truths, movie);
  report.write(result, parts, truths, scans.drawn(), views_of(session.plugins()),
               summary_json(summary));
  std::vector<std::string> told;
  session.publish(result, [&] { told = out.publish(summary_json(summary)); });
  if (watchers.published) watchers.published(made.outcome);
  warn(summary, told);
  return made;
}

}  // namespace

Attempt attempt(const ReplayRequest& request, const Watchers& watchers,
                std::chrono::steady_clock::time_point start, const Conditions& conditions) {
  std::string doubt;
  Attempt made = attempt_once(request, watchers, start, conditions, doubt);
  return doubt.empty() ? made : attempt_once(request, watchers, start, conditions, doubt);
}

}  // namespace hybrid
