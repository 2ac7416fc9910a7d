// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-experiment/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <future>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <thread>
#include <utility>

#include "apps/exit_code.h"
#include "apps/hybrid-experiment/trial_runner.h"
#include "apps/program.h"
#include "apps/progress_line.h"
#include "libhybrid/core/elapsed.h"
#include "libhybrid/core/error.h"
#include "libhybrid/io/folders.h"
#include "libhybrid/io/regular_file.h"
#include "libhybrid/io/write_file.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/experiment/ledger.h"
#include "mrpt_plugins/experiment/plots.h"
#include "mrpt_plugins/experiment/pose_graph_trial.h"
#include "mrpt_plugins/experiment/replay_trial.h"
#include "mrpt_plugins/experiment/statistics.h"
#include "mrpt_plugins/output/figures.h"
#include "mrpt_plugins/report/graph_report.h"
#include "mrpt_plugins/report/page.h"

namespace hybrid {
namespace {

/// Progress on standard error: how many trials have ended. One line that is rewritten on a
/// terminal; in a pipe, a line per twentieth.
class Progress {
 public:
  /// `todo` is the number of trials to run.
  explicit Progress(std::size_t todo) : todo_(todo) {}

  /// Counts a trial that ended; `what` names it.
  void ended(const std::string& what);
  /// Prints a separate line.
  void message(const std::string& text) { line_.message(text); }

 private:
  void show(const std::string& what);

  std::size_t todo_;
  std::size_t done_ = 0;
  std::size_t twentieths_ = 0;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  ProgressLine line_;
};

void Progress::ended(const std::string& what) {
  ++done_;
  const std::size_t twentieths = 20 * done_ / todo_;
  if (line_.terminal() || twentieths != twentieths_) show(what);
  twentieths_ = twentieths;
}

void Progress::show(const std::string& what) {
  const double left =
      seconds_since(start_) / static_cast<double>(done_) * static_cast<double>(todo_ - done_);
  line_.show(fmt::format("{:3d} %  {} of {} trials  about {:.0f} s left  {}", 100 * done_ / todo_,
                         done_, todo_, left, what));
}

namespace fs = std::filesystem;

constexpr const char* kSettings = "settings.txt";
constexpr const char* kVersion = "version";
// Files that outlast results: finished trials are kept, whatever happens to the other files.
const std::vector<std::string> kLasting = {"results.csv", kSettings, "experiment.ini"};

void apply(const Options& options, IniFile& ini) {
  ini.override_values(options.settings);
  if (!options.data_dir.empty()) {
    ini.override_value("experiment", "data_dir", fs::absolute(options.data_dir).string());
  }
  if (options.jobs > 0) {
    ini.override_value("experiment", "jobs", std::to_string(options.jobs));
  }
}

/// Throws Error if the folder has results of other settings; otherwise writes down the settings.
/// Settings that only one of the two has belong to graphs or methods that were added or left out.
/// All versions of the program are written down.
void check_settings(const fs::path& folder, const ExperimentPlan& plan, const std::string& version,
                    bool has_results) {
  std::map<std::string, std::string> all = plan.fingerprint;
  std::string versions;
  const fs::path before_them = folder / kSettings;
  std::istringstream in(name_exists(before_them) ? read_file(before_them.string()) : "");
  for (std::string line; std::getline(in, line);) {
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) continue;
    const std::string name = line.substr(0, equals), before = line.substr(equals + 1);
    if (name == kVersion) {
      versions = before;
      continue;
    }
    const auto it = all.emplace(name, before).first;
    if (it->second != before) {
      throw Error(
          fmt::format("{}: the results there are of other settings: {} was '{}' and is now "
                      "'{}'; use another -o, or remove the folder",
                      folder.string(), name, before, it->second));
    }
  }
  if (has_results && versions.empty()) versions = "an older one";
  if (has_results && versions != version) {
    complain("hybrid-experiment: warning: {} has results of version {}, and this is {}\n",
             folder.string(), versions, version);
  }
  if (versions.empty()) versions = version;
  if (("; " + versions + ";").find("; " + version + ";") == std::string::npos) {
    versions += "; " + version;
  }
  std::string text;
  for (const auto& [name, value] : all) text += fmt::format("{}={}\n", name, value);
  write_file(folder / kSettings, text + fmt::format("{}={}\n", kVersion, versions));
}

/// Settings and versions that must agree between the ranks.
std::string greeting_of(const ExperimentPlan& plan, const Provenance& provenance) {
  std::string text = "version=" + provenance.version + "\n";
  for (const auto& [name, value] : plan.fingerprint) text += fmt::format("{}={}\n", name, value);
  return text;
}

class Experiment {
 public:
  Experiment(const ExperimentPlan& plan, const Provenance& provenance, const fs::path& folder,
             Ledger& ledger)
      : plan_(plan), runner_(plan, provenance, folder), ledger_(ledger) {}

  /// The trials without a result, and with `retry` those that failed.
  std::vector<Trial> missing(bool retry) const {
    std::vector<Trial> all = trials_of(plan_), missing;
    std::copy_if(all.begin(), all.end(), std::back_inserter(missing), [&](const Trial& trial) {
      if (!ledger_.contains(trial)) return true;
      const TrialResult& result = ledger_.at(trial);
      return !result.finished() || (retry && result.bad());
    });
    if (missing.size() < all.size()) {
      complain("{} of {} trials have been run before\n", all.size() - missing.size(), all.size());
    }
    return missing;
  }

  /// Runs trials on this machine until the program is interrupted.
  void run(const std::vector<Trial>& trials) {
    Progress progress(trials.size());
    const auto cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    // Trials on one file run in sequence, so that only one graph is in memory.
    for (std::size_t begin = 0; begin < trials.size() && interrupted() == 0;) {
      std::size_t end = begin;
      while (end < trials.size() && same_file(trials[begin], trials[end])) ++end;
      runner_.prepare(trials[begin]);
      runner_.run(
          {trials.begin() + begin, trials.begin() + end}, plan_.jobs > 0 ? plan_.jobs : cores,
          [&](const Trial& trial, const TrialResult& result) { record(trial, result, progress); },
          [] { return interrupted() != 0; });
      begin = end;
    }
  }

  /// Runs trials on the other ranks until the program is interrupted.
  void run(const std::vector<Trial>& trials, Workers& workers, const std::string& greeting) {
    Progress progress(trials.size());
    std::vector<std::string> names;
    for (const Trial& trial : trials) names.push_back(trial.key());
    Workers::Events events;
    events.done = [&](std::size_t i, const std::string& text) {
      record(trials[i], result_of_text(text), progress);
    };
    events.lost = [&](std::size_t i, const std::string& why) {
      TrialResult result;
      result.status = "unfinished";
      result.message = why;
      record(trials[i], result, progress);
    };
    events.refused = [&](const std::string& why) { progress.message(why); };
    events.stop = [] { return interrupted() != 0; };
    workers.run(names, greeting, plan_.rank_silence, events);
  }

 private:
  static bool same_file(const Trial& a, const Trial& b) {
    return a.graph == b.graph && a.variant == b.variant;
  }

  void record(const Trial& trial, const TrialResult& result, Progress& progress) {
    ledger_.append(trial, result);
    if (!result.finished() || result.status == "failed" || result.status == "crashed") {
      progress.message(fmt::format("{}: {}: {}", trial.key(), result.status, result.message));
    }
    progress.ended(trial.key());
  }

  const ExperimentPlan& plan_;
  TrialRunner runner_;
  Ledger& ledger_;
};

void draw(const ExperimentPlan& plan, const Ledger& ledger, const std::vector<PointSummary>& points,
          const OutputDirectory& out) {
  for (const GraphPlan& graph : plan.graphs) {
    out.write(graph.name + ".png",
              png(comparison_image(plan, graph.name, points, ledger.metrics())));
  }
  if (plan.replay) {
    for (const std::string& metric : ledger.metrics()) {
      out.write(metric + ".png", png(replay_image(plan, metric, points, ledger.metrics())));
    }
    return;
  }
  for (const std::string& method : plan.methods) {
    const Calibration calibration = calibration_of(plan, ledger, method);
    if (calibration.predictions == 0) continue;
    out.write(
        "reliability_" + method + ".png",
        png(reliability_image(calibration, "Inlier probabilities of " + method, kOfClosures)));
  }
}

}  // namespace

std::string config_text(const Options& options) {
  IniFile ini = options.config.empty() ? IniFile() : IniFile(fs::path(options.config));
  apply(options, ini);
  read_plan(ini);
  return ini.documentation();
}

namespace {

/// Number of trials of the plan by status; trials without a result are "missing".
std::map<std::string, std::size_t> counts_of(const ExperimentPlan& plan, const Ledger& ledger) {
  std::map<std::string, std::size_t> counts;
  for (const Trial& trial : trials_of(plan)) {
    ++counts[ledger.contains(trial) ? ledger.at(trial).status : "missing"];
  }
  return counts;
}

/// Message about trials that failed; empty if none did.
std::string complaint(const std::map<std::string, std::size_t>& counts) {
  std::string text;
  for (const char* status : {"failed", "crashed", "unfinished"}) {
    const auto it = counts.find(status);
    if (it == counts.end()) continue;
    text += fmt::format("{}{} trials {}", text.empty() ? "" : ", ", it->second, status);
  }
  if (counts.count("unfinished") != 0) text += "; run again to try these once more";
  return text;
}

nlohmann::ordered_json summary_json(const ExperimentPlan& plan, const Provenance& provenance,
                                    const std::map<std::string, std::size_t>& counts) {
  const std::string message = complaint(counts);
  auto json = summary_start(message.empty() ? "ok" : "partial", message, provenance);
  json["title"] = plan.title;
  json["trials"] = counts;
  return json;
}

}  // namespace

int run_experiment(const Options& options, Channel* ranks) {
  std::optional<Workers> workers;
  if (ranks != nullptr) workers.emplace(*ranks);
  IniFile ini{fs::path(options.config)};
  apply(options, ini);
  const ExperimentPlan plan = read_plan(ini);
  warn_of(ini.warnings());
  OutputDirectory out(options.output, kLasting);
  Ledger ledger(out.folder(), plan.replay ? replay_metrics(plan) : pose_graph_metrics());
  check_settings(out.folder(), plan, options.provenance.version, !ledger.empty());
  write_file(out.folder() / "experiment.ini", ini.documentation());
  Provenance provenance = options.provenance;
  provenance.add_input(options.config);
  provenance.inputs.insert(provenance.inputs.end(), plan.inputs.begin(), plan.inputs.end());
  provenance.configuration = ini.settings();
  warn_of_inputs(provenance);

  Experiment experiment(plan, provenance, out.folder(), ledger);
  const std::vector<Trial> missing = experiment.missing(options.retry);
  if (!missing.empty() && !options.summary_only) {
    workers ? experiment.run(missing, *workers, greeting_of(plan, provenance))
            : experiment.run(missing);
  }
  const std::map<std::string, std::size_t> counts = counts_of(plan, ledger);
  if (const int signal = interrupted(); signal != 0) {
    const auto missing = counts.find("missing");
    complain("hybrid-experiment: stopped by {}, {} trials are yet to be run; run again to go on\n",
             signal_name(signal), missing == counts.end() ? 0 : missing->second);
    return kExitInterrupted + signal;
  }
  const std::vector<PointSummary> points = summarize(plan, ledger);
  const std::string table = summary_table(plan, points, ledger.metrics());
  out.write("summary.csv", summary_csv(points, ledger.metrics()));
  out.write("summary.txt", table);
  draw(plan, ledger, points, out);
  out.write("results.csv", ledger.text(trials_of(plan)));
  auto summary = summary_json(plan, provenance, counts);
  if (options.report) {
    out.write("report.html",
              report_page(trials_report_json(plan.title, ledger.text(trials_of(plan)), summary)));
  }
  const bool partial = summary.contains("message");
  const std::vector<std::string> told = out.publish(std::move(summary));
  const int code = settle(partial ? kExitPartial : kExitOk);
  for (const std::string& text : told) complain("hybrid-experiment: {}\n", text);
  say("{}-> {}\n", table, options.output);
  if (code != kExitOk) {
    complain("hybrid-experiment: {}: see {}\n", complaint(counts),
             (out.folder() / "results.csv").string());
  }
  return code;
}

int serve_experiment(const Options& options, Channel& ranks) {
  std::optional<IniFile> ini;
  ExperimentPlan plan;
  std::map<std::string, Trial> trials;
  std::optional<TrialRunner> runner;
  const auto greeting = [&] {
    ini.emplace(fs::path(options.config));
    apply(options, *ini);
    plan = read_plan(*ini);
    for (const Trial& trial : trials_of(plan)) trials.emplace(trial.key(), trial);
    runner.emplace(plan, options.provenance, options.output);
    return greeting_of(plan, options.provenance);
  };
  const auto run = [&](const std::string& name, const AtWork& at_work) {
    const auto trial = trials.find(name);
    if (trial == trials.end()) throw Error("there is no trial " + name + " in " + options.config);
    // In another thread, so that this one can tell that it is at work.
    auto prepared = std::async(std::launch::async, [&] { runner->prepare(trial->second); });
    while (prepared.wait_for(std::chrono::milliseconds(10)) != std::future_status::ready) at_work();
    prepared.get();
    std::optional<std::string> text;
    runner->run(
        {trial->second}, 1,
        [&](const Trial&, const TrialResult& result) { text = result_text(result); },
        [&] { return !at_work(); });
    return text;
  };
  serve(ranks, greeting, run);
  const int signal = interrupted();
  return signal == 0 ? kExitOk : kExitInterrupted + signal;
}

}  // namespace hybrid
