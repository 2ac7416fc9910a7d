// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-replay/replay.h"

#include <fmt/format.h>

#include <chrono>
#include <utility>

#include "apps/exit_code.h"
#include "apps/hybrid-replay/movie.h"
#include "apps/hybrid-replay/outputs.h"
#include "apps/hybrid-replay/progress.h"
#include "apps/hybrid-replay/settings.h"
#include "apps/hybrid-replay/truth.h"
#include "libhybrid/core/elapsed.h"
#include "libhybrid/core/error.h"
#include "mrpt_plugins/input/mode_truth.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/output/sparsity.h"
#include "mrpt_plugins/output/summary.h"
#include "mrpt_plugins/output/video.h"

namespace hybrid {
namespace {

using Clock = std::chrono::steady_clock;

constexpr int kVideoFrames = 100;  // where --frames does not say

std::size_t count_keyframes(const Settings& settings) {
  KeyframeSource source(settings.rawlog, settings.source);
  std::size_t count = 0;
  while (source.next()) ++count;
  return count;
}

/// The film that is asked for, or none.
Movie make_movie(const Options& options, const Settings& settings) {
  if (!options.video.empty()) check_video(options.video);
  const bool asked = options.frames > 0 || !options.video.empty();
  if (!asked) return {0, 0};
  return {options.frames > 0 ? options.frames : kVideoFrames, count_keyframes(settings)};
}

/// Feeds the whole log to the mapper and solves to convergence.
BackendReport run(KeyframeSource& source, Mapper& mapper, Progress& progress, Movie& movie) {
  std::size_t keyframes = 0;
  while (const auto keyframe = source.next()) {
    const StepRecord& step = mapper.add(*keyframe);
    progress.update(source.progress(), ++keyframes, step.landmarks, step.objective);
    if (movie.size() > 0) movie.watch(keyframes, mapper);
  }
  if (keyframes == 0) {
    throw Error(source.message().empty() ? "the log holds no frame to map" : source.message());
  }
  return mapper.finish();
}

/// Whether something odd in a log was dropped, repaired or missing; the rest is for information.
bool is_loss(const std::string& what) {
  const auto has = [&](const char* word) { return what.find(word) != std::string::npos; };
  return has(" dropped: ") || has(" repaired: ") || has(" missing: a gap");
}

Summary summarize(const KeyframeSource& source, const Mapper& mapper, const BackendReport& last,
                  const MapResult& result) {
  Summary summary;
  if (source.status() != LogStatus::kComplete) {
    summary.status = "partial";
    summary.message = source.message();
  }
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
  summary.warnings.insert(summary.warnings.end(), last.warnings.begin(), last.warnings.end());
  summary.calibration = result.calibration;
  for (const int mode : result.motion_modes) {
    if (mode >= 0) ++summary.modes[result.mode_names[static_cast<std::size_t>(mode)]];
  }
  if (result.landmarks.empty()) {
    summary.warnings.push_back("no landmark was mapped: no plugin found a detection to use");
  }
  return summary;
}

/// What only the command line asks for: matrices, frames, video. Returns warnings.
std::vector<std::string> write_extras(const Options& options, const OutputDirectory& out,
                                      const MapResult& result, const GroundTruth& truth,
                                      const Mapper& mapper, Movie& movie) {
  std::vector<std::string> warnings;
  if (options.sparsity) {
    const Backend& backend = mapper.backend();
    warnings = write_sparsity(out, backend.graph(), backend.assignment(),
                              backend.elimination_order(), result.title);
  }
  if (movie.size() > 0) movie.finish(result);
  if (options.frames > 0) movie.write_frames(OutputDirectory(out.folder() / "frames"), truth);
  if (!options.video.empty()) {
    save_video(options.video, movie.size(), [&](int i) { return movie.frame(i, truth); });
  }
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
  fmt::print("{}:\n", calibration.name);
  for (const CalibrationEstimate::Entry& e : calibration.entries) {
    if (e.observed) {
      fmt::print("  {} {:.4f} +- {:.4f} {} (start {:.4f})\n", e.name, e.value, e.sigma, e.unit,
                 e.start);
    } else {
      fmt::print("  {} is not determined by the measurements of this log\n", e.name);
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
  fmt::print("{} keyframes, {} landmarks, objective {:.6g}, {:.3f} s ({:.3f} s solving)",
             summary.keyframes, summary.landmarks, summary.objective, summary.total_s,
             summary.solver_s);
  if (summary.truth && summary.truth->trajectory) {
    fmt::print(", path rmse {:.4f} m", summary.truth->trajectory->unaligned.rmse_m);
  }
  if (summary.truth && summary.truth->landmarks) {
    fmt::print(", landmarks mean {:.4f} m", summary.truth->landmarks->mean_m);
  }
  if (summary.truth && summary.truth->associations && summary.truth->associations->labelled > 0) {
    fmt::print(", associations right {:.2f} %", 100 * summary.truth->associations->accuracy());
  }
  if (summary.truth && summary.truth->modes) {
    fmt::print(", modes precision {:.3f} recall {:.3f}", summary.truth->modes->precision(),
               summary.truth->modes->recall());
  }
  fmt::print(" -> {}\n", out.folder().string());
}

}  // namespace

int replay(const Options& options) {
  const auto start = Clock::now();
  IniFile ini(options.config);
  Settings settings = read_settings(ini, options);
  Truth truth(settings.truth_path, settings.truth_map, settings.truth_point);
  if (!settings.truth_associations.empty()) truth.read_associations(settings.truth_associations);
  KeyframeSource source(settings.rawlog, settings.source);
  const OutputDirectory out(options.output);

  Movie movie = make_movie(options, settings);

  Progress progress;
  Mapper mapper(settings.motion, std::move(settings.plugins), std::move(settings.backend),
                source.is_3d(), settings.calibration);
  const BackendReport last = run(source, mapper, progress, movie);

  MapResult result = mapper.result();
  result.title = settings.title;
  Summary summary = summarize(source, mapper, last, result);
  truth.adapt_to(result, mapper.log_rows());
  summary.truth = compare(truth, result, mapper, settings.match_radius);
  summary.truth->modes = mode_score(settings, result, mapper);
  if (truth.empty() && !summary.truth->associations && !summary.truth->modes) summary.truth.reset();
  const auto warn = [&](const std::vector<std::string>& warnings) {
    summary.warnings.insert(summary.warnings.end(), warnings.begin(), warnings.end());
  };
  warn(write_texts(out, result, mapper.backend()));
  summary.total_s = seconds_since(start);
  if (options.pictures) {
    warn(write_pictures(out, result, truth.get()));
    write_error_plot(out, result, truth, mapper.log_rows());
  }
  warn(write_extras(options, out, result, truth.get(), mapper, movie));
  out.write("summary.json", summary_json(summary));
  report(summary, out, progress);
  return summary.status == "ok" ? kExitOk : kExitPartial;
}

}  // namespace hybrid
