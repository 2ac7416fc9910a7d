// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-replay/replay.h"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/exit_code.h"
#include "apps/hybrid-replay/film.h"
#include "apps/hybrid-replay/movie.h"
#include "apps/hybrid-replay/outputs.h"
#include "apps/hybrid-replay/progress.h"
#include "apps/hybrid-replay/settings.h"
#include "apps/hybrid-replay/truth.h"
#include "apps/program.h"
#include "libhybrid/core/elapsed.h"
#include "libhybrid/core/error.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/input/mode_truth.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/output/sparsity.h"
#include "mrpt_plugins/output/summary.h"

namespace hybrid {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kVideoFrames = 100;  // where --frames does not say

std::size_t count_keyframes(const Settings& settings) {
  KeyframeSource source(settings.rawlog, settings.source);
  std::size_t count = 0;
  while (source.next()) {
    throw_if_interrupted();
    ++count;
  }
  return count;
}

/// The pictures of the growing map that are asked for, or none.
Movie make_movie(const Options& options, const Settings& settings) {
  const bool asked = options.frames > 0 || !options.video.empty();
  if (!asked) return {0, 0};
  return {options.frames > 0 ? options.frames : kVideoFrames, count_keyframes(settings)};
}

/// How a replay ended.
struct Ending {
  BackendReport last;
  int signal = 0;  ///< that stopped it with keyframes left; 0: none did
};

/// Feeds the log to the mapper, until the program is asked to stop, and solves to convergence.
Ending run(KeyframeSource& source, Mapper& mapper, Progress& progress, Movie& movie) {
  int signal = 0;
  std::size_t keyframes = 0;
  while (const auto keyframe = source.next()) {
    signal = interrupted();
    if (signal != 0) break;
    const StepRecord& step = mapper.add(*keyframe);
    progress.update(source.progress(), ++keyframes, step.landmarks, step.objective);
    if (movie.size() > 0) movie.watch(keyframes, mapper);
  }
  if (keyframes == 0) {
    throw_if_interrupted();
    throw Error(source.message().empty() ? "the log holds no frame to map" : source.message());
  }
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

/// Status and message; `signal` is what stopped the replay, or 0.
void judge(const KeyframeSource& source, const Mapper& mapper, const MapResult& result, int signal,
           Summary& summary) {
  const std::string refused = refusals(mapper);
  if (signal != 0) {
    summary.status = "interrupted";
    summary.message =
        fmt::format("stopped by {} after {} keyframes, {:.1f} % of the log", signal_name(signal),
                    result.trajectory.size(), 100 * source.progress());
  } else if (source.status() != LogStatus::kComplete) {
    summary.status = "partial";
    summary.message = source.message();
  } else if (result.landmarks.empty() && refused.empty()) {
    summary.status = "empty";
    summary.message = "no landmark was mapped: no plugin found a detection to use";
  } else if (!refused.empty()) {
    summary.status = "partial";
  }
  if (refused.empty()) return;
  summary.message += (summary.message.empty() ? "" : "; ") + refused;
}

Summary summarize(const KeyframeSource& source, const Mapper& mapper, const BackendReport& last,
                  const MapResult& result, int signal) {
  Summary summary;
  judge(source, mapper, result, signal, summary);
  summary.mode = mapper.backend().mode();
  summary.keyframes = result.trajectory.size();
  summary.landmarks = result.landmarks.size();
  summary.objective = last.objective;
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
    summary.warnings.push_back(fmt::format("{} ({} times)", what, count));
  }
  for (const auto& more : {mapper.warnings(), last.warnings}) {
    summary.warnings.insert(summary.warnings.end(), more.begin(), more.end());
  }
  summary.calibration = result.calibration;
  for (const int mode : result.motion_modes) {
    if (mode >= 0) ++summary.modes[result.mode_names[static_cast<std::size_t>(mode)]];
  }
  return summary;
}

/// What only the command line asks for: matrices, frames, video. Returns warnings.
std::vector<std::string> write_extras(const Options& options, const OutputDirectory& out,
                                      const MapResult& result, const GroundTruth& truth,
                                      const Mapper& mapper, Movie& movie, const Film& film) {
  std::vector<std::string> warnings;
  if (options.sparsity) {
    const Backend& backend = mapper.backend();
    warnings = write_sparsity(out, backend.graph(), backend.assignment(),
                              backend.elimination_order(), result.title);
  }
  if (movie.size() > 0) movie.finish(result);
  if (options.frames > 0) movie.write_frames(out, truth);
  if (film.wanted()) film.encode(movie.size(), [&](int i) { return movie.frame(i, truth); });
  return warnings;
}

/// How well slip was found, where the true modes are known.
std::optional<ModeScore> mode_score(const Settings& settings, const MapResult& result,
                                    const Mapper& mapper) {
  if (settings.truth_modes.empty()) return std::nullopt;
  const std::vector<int> truth = read_true_modes(settings.truth_modes);
  if (result.mode_names.empty()) return std::nullopt;
  return score_modes(result, mapper.log_rows(), truth);
}

/// Tells what was found of the robot itself, on standard output.
void report(const CalibrationEstimate& calibration) {
  say("{}:\n", calibration.name);
  for (const CalibrationEstimate::Entry& e : calibration.entries) {
    if (e.observed) {
      say("  {} {:.4f} +- {:.4f} {} (start {:.4f})\n", e.name, e.value, e.sigma, e.unit, e.start);
    } else {
      say("  {} is not determined by the measurements of this log\n", e.name);
    }
  }
}

void report(const Summary& summary, const OutputDirectory& out, Progress& progress) {
  progress.clear();
  for (const auto& [reason, count] : summary.dropped) {
    progress.message(fmt::format("{}: {}", reason, count));
  }
  for (const std::string& warning : summary.warnings) progress.message("warning: " + warning);
  if (summary.status != "ok") progress.message("error: " + summary.message);
  for (const CalibrationEstimate& calibration : summary.calibration) report(calibration);
  say("{} keyframes, {} landmarks, objective {:.6g}, {:.3f} s ({:.3f} s solving)",
      summary.keyframes, summary.landmarks, summary.objective, summary.total_s, summary.solver_s);
  if (summary.truth && summary.truth->trajectory) {
    say(", path rmse {:.4f} m", summary.truth->trajectory->unaligned.rmse_m);
  }
  if (summary.truth && summary.truth->landmarks && summary.truth->landmarks->matched > 0) {
    say(", landmarks mean {:.4f} m", summary.truth->landmarks->mean_m);
  }
  if (summary.truth && summary.truth->associations && summary.truth->associations->labelled > 0) {
    say(", associations right {:.2f} %", 100 * summary.truth->associations->accuracy());
  }
  if (summary.truth && summary.truth->modes) {
    say(", modes precision {:.3f} recall {:.3f}", summary.truth->modes->precision(),
        summary.truth->modes->recall());
  }
  say(" -> {}\n", out.folder().string());
}

/// All files that a replay reads.
Provenance provenance(const Options& options, const Settings& settings, const IniFile& ini) {
  Provenance provenance = options.provenance;
  provenance.configuration = ini.settings();
  for (const std::string& path :
       {settings.rawlog, options.config, settings.truth_path, settings.truth_map,
        settings.truth_associations, settings.truth_modes}) {
    provenance.add_input(path);
  }
  for (const std::string& path : options.plugin_libraries) provenance.add_input(path);
  return provenance;
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

}  // namespace

int replay(const Options& options) {
  const auto start = Clock::now();
  note_interrupts();
  IniFile ini(options.config);
  Settings settings = read_settings(ini, options);
  Truth truth(settings.truth_path, settings.truth_map, settings.truth_point);
  if (!settings.truth_associations.empty()) truth.read_associations(settings.truth_associations);
  KeyframeSource source(settings.rawlog, settings.source);
  OutputDirectory out(options.output);
  Film film(options.video, out);

  Movie movie = make_movie(options, settings);

  Progress progress;
  Mapper mapper(settings.motion, std::move(settings.plugins), std::move(settings.backend),
                source.is_3d(), settings.calibration);
  const auto [last, signal] =
      about({settings.rawlog}, [&] { return run(source, mapper, progress, movie); });

  MapResult result = about({settings.rawlog}, [&] { return mapper.result(); });
  result.title = settings.title;
  Summary summary = summarize(source, mapper, last, result, signal);
  truth.adapt_to(result, mapper.log_rows());
  summary.truth = compare(truth, result, mapper, settings.match_radius);
  summary.truth->modes = mode_score(settings, result, mapper);
  if (truth.empty() && !summary.truth->associations && !summary.truth->modes) summary.truth.reset();
  summary.provenance = provenance(options, settings, ini);
  for (const Provenance::Input& input : summary.provenance.inputs) {
    if (!input.warning.empty()) summary.warnings.push_back(input.path + ": " + input.warning);
  }
  const auto warn = [&](const std::vector<std::string>& warnings) {
    summary.warnings.insert(summary.warnings.end(), warnings.begin(), warnings.end());
  };
  warn(write_texts(out, result, mapper.backend()));
  summary.total_s = seconds_since(start);
  if (options.pictures) {
    warn(write_pictures(out, result, truth.get()));
    write_error_plot(out, result, truth, mapper.log_rows());
  }
  warn(write_extras(options, out, result, truth.get(), mapper, movie, film));
  const std::vector<std::string> told = publish(summary, out, film);
  const int code = settle(signal != 0              ? kExitInterrupted + signal
                          : summary.status == "ok" ? kExitOk
                                                   : kExitPartial);
  warn(told);
  report(summary, out, progress);
  return code;
}

}  // namespace hybrid
