// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <string>

#include "apps/exit_code.h"
#include "apps/hybrid-replay/options.h"
#include "apps/program.h"
#include "apps/progress_line.h"
#include "mrpt_plugins/health/health_lines.h"
#include "mrpt_plugins/job/replay.h"
#include "mrpt_plugins/mapping/plugin_library.h"
#include "mrpt_plugins/settings/replay_request.h"
#include "mrpt_plugins/settings/replay_settings.h"

namespace hybrid {
namespace {

/// Tells the user how far a replay is, on standard error: one line that renews itself on a
/// terminal; in a pipe nothing but the messages.
class Progress {
 public:
  /// Renews the line, at most ten times per second. `fraction` of the log is done, where known.
  void update(std::optional<double> fraction, std::size_t keyframes, std::size_t landmarks,
              double objective);

  /// Prints a line of its own.
  void message(const std::string& text) { line_.message(text); }
  /// Removes the line.
  void clear() { line_.clear(); }

 private:
  ProgressLine line_;
};

void Progress::update(std::optional<double> fraction, std::size_t keyframes, std::size_t landmarks,
                      double objective) {
  if (!line_.is_due()) return;
  const std::string share = fraction ? fmt::format("{:3.0f} %  ", 100 * *fraction) : "";
  line_.show(fmt::format("{}{} keyframes  {} landmarks  objective {:.6g}  {:.0f}/s  {}", share,
                         keyframes, landmarks, objective,
                         static_cast<double>(keyframes) / line_.elapsed(),
                         fraction ? line_.time_left(*fraction) : ""));
}

/// Tells what was found of the robot itself.
void report(const CalibrationEstimate& calibration, std::FILE* file) {
  print_to(file, "{}:\n", calibration.name);
  for (const CalibrationEstimate::Entry& e : calibration.entries) {
    if (e.observed) {
      print_to(file, "  {} {:.4f} +- {:.4f} {} (start {:.4f})\n", e.name, e.value, e.sigma, e.unit,
               e.start);
    } else {
      print_to(file, "  {} is not determined by the measurements of this log\n", e.name);
    }
  }
}

/// Tells which plugins were chosen, and what of the log nobody uses.
void report_plugins(const Summary& summary, Progress& progress, std::FILE* file) {
  if (!summary.chosen_plugins.empty()) {
    print_to(file, "plugins chosen by what the log holds: {}\n",
             fmt::format("{}", fmt::join(summary.chosen_plugins, ", ")));
  }
  for (const auto& [name, use] : summary.observations) {
    if (use.users.empty()) progress.message(fmt::format("not used: {} {}", use.count, name));
  }
}

/// The errors of the robots whose true path is known, in brackets; "" where there is none.
std::string errors_of_robots(const std::vector<RobotSummary>& robots) {
  std::vector<std::string> errors;
  for (const RobotSummary& robot : robots) {
    if (!robot.truth || !robot.truth->trajectory) continue;
    if (!robot.truth->trajectory->is_telling()) continue;
    errors.push_back(
        fmt::format("{} {:.4f} m", robot.name, robot.truth->trajectory->unaligned.rmse_m));
  }
  return errors.empty() ? "" : fmt::format(" ({})", fmt::join(errors, ", "));
}

/// The error of the path, and how many keyframes have a true pose where that is not all; "" where
/// none has.
std::string error_of_path(const Summary& s) {
  if (!s.truth || !s.truth->trajectory || s.truth->trajectory->poses == 0) return "";
  const TrajectoryReport& path = *s.truth->trajectory;
  const std::string number = fmt::format("{} of {} keyframes {} a true pose", path.poses,
                                         s.keyframes, path.poses == 1 ? "has" : "have");
  if (!path.is_telling()) return ", " + number;
  return fmt::format(", path rmse {:.4f} m{}", path.unaligned.rmse_m,
                     path.poses < s.keyframes ? " (" + number + ")" : "");
}

/// What a first look at a result asks: how long, how good, and where in a given map.
std::string first_words(const Summary& s) {
  std::string text = fmt::format("{} keyframes, ", s.keyframes);
  if (s.landmarks > 0 || (s.statistics.count("scans") == 0 && s.statistics.count("clouds") == 0)) {
    text += fmt::format("{} landmarks, ", s.landmarks);
  }
  text += fmt::format("path {:.4g} m, health {}", s.path_m, to_string(worst(s.health)));
  const bool is_open = std::any_of(s.health.begin(), s.health.end(), [](const HealthEntry& entry) {
    return entry.verdict == HealthVerdict::kNotJudged;
  });
  if (is_open) text += " as far as it can be judged";
  if (!s.localized_at) return text;
  return text + fmt::format(", localised at keyframe {}", *s.localized_at);
}

void report(const Summary& summary, const std::string& folder, Progress& progress,
            std::FILE* file) {
  progress.clear();
  report_plugins(summary, progress, file);
  for (const auto& [reason, count] : summary.dropped) {
    progress.message(fmt::format("{}: {}", reason, count));
  }
  for (const std::string& warning : summary.warnings) progress.message("warning: " + warning);
  for (const std::string& line : health_lines(summary.health)) progress.message(line);
  if (summary.status != "ok") progress.message("error: " + summary.message);
  for (const CalibrationEstimate& calibration : summary.calibration) report(calibration, file);
  print_to(file, "{}, {:.3f} s{}{}", first_words(summary), summary.total_s, error_of_path(summary),
           errors_of_robots(summary.robots));
  if (summary.truth && summary.truth->landmarks && summary.truth->landmarks->matched > 0) {
    print_to(file, ", landmarks mean {:.4f} m", summary.truth->landmarks->mean_m);
  }
  if (summary.truth && summary.truth->associations && summary.truth->associations->labelled > 0) {
    print_to(file, ", associations right {:.2f} %", 100 * summary.truth->associations->accuracy());
  }
  if (summary.truth && summary.truth->modes) {
    print_to(file, ", modes precision {:.3f} recall {:.3f}", summary.truth->modes->precision(),
             summary.truth->modes->recall());
  }
  if (summary.truth && summary.truth->fixes) {
    const FixScore& fixes = *summary.truth->fixes;
    print_to(file, ", false fixes precision {:.3f} recall {:.3f}", fixes.wrong.precision(),
             fixes.wrong.recall());
    if (fixes.calibration_error) print_to(file, ", off by {:.3f}", *fixes.calibration_error);
  }
  print_to(file, " -> {}\n", folder);
}

int exit_code(const ReplayOutcome& outcome, bool strict) {
  if (outcome.signal != 0) return kExitInterrupted + outcome.signal;
  if (strict && worst(outcome.summary.health) == HealthVerdict::kBad) return kExitPartial;
  return outcome.summary.status == "ok" ? kExitOk : kExitPartial;
}

/// Replays, with progress, and prints what came of it. Returns the exit code; throws on failure.
/// `strict`: where a run says of itself that it is wrong, the exit code is that of a partial
/// result.
int run(const ReplayRequest& request, bool strict) {
  note_interrupts();
  Progress progress;
  const ReplayOutcome outcome = replay(
      request,
      [&](const ReplayProgress& so_far) {
        progress.update(so_far.fraction, so_far.keyframes, so_far.landmarks, so_far.objective);
        if (!request.stream) return;
        say("{}\n", so_far.line);
        std::fflush(stdout);
      },
      [strict](const ReplayOutcome& published) { settle(exit_code(published, strict)); });
  report(outcome.summary, outcome.folder.string(), progress, request.stream ? stderr : stdout);
  return exit_code(outcome, strict);
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) {
  return hybrid::run_program("hybrid-replay", [&] {
    int exit_code = hybrid::kExitOk;
    const auto options = hybrid::parse_options(argc, argv, exit_code);
    if (!options) return exit_code;
    for (const std::string& path : options->request.plugin_libraries)
      hybrid::load_plugin_library(path);
    if (!options->print_config) return hybrid::run(options->request, options->strict);
    fmt::print("{}", hybrid::config_text(options->request));
    return static_cast<int>(hybrid::kExitOk);
  });
}
