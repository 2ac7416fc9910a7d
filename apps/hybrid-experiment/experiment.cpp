// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-experiment/experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <thread>

#include "apps/exit_code.h"
#include "apps/hybrid-experiment/progress.h"
#include "apps/program.h"
#include "libhybrid/core/error.h"
#include "libhybrid/io/write_file.h"
#include "mrpt_plugins/bridge/interrupt.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/experiment/ledger.h"
#include "mrpt_plugins/experiment/plots.h"
#include "mrpt_plugins/experiment/pose_graph_trial.h"
#include "mrpt_plugins/experiment/processes.h"
#include "mrpt_plugins/experiment/replay_trial.h"
#include "mrpt_plugins/experiment/statistics.h"
#include "mrpt_plugins/output/figures.h"
#include "mrpt_plugins/report/graph_report.h"
#include "mrpt_plugins/report/page.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSettings = "settings.txt";
constexpr const char* kVersion = "version";
// Files that outlast results: finished trials are kept, whatever happens to the other files.
const std::vector<std::string> kLasting = {"results.csv", kSettings, "experiment.ini"};

void apply(const Options& options, IniFile& ini) {
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
  std::ifstream in(folder / kSettings);
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

std::string to_text(const TrialResult& result) {
  nlohmann::json json;
  json["status"] = result.status;
  json["metrics"] = result.metrics;
  json["reliability"] = result.reliability;
  json["message"] = result.message;
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

TrialResult to_result(const ProcessEnd& end, double time_limit) {
  TrialResult result;
  if (end.kind == ProcessEnd::Kind::kDone) {
    const auto json = nlohmann::json::parse(end.text);
    result.status = json.at("status").get<std::string>();
    for (const auto& [name, value] : json.at("metrics").items()) {
      if (value.is_number()) result.metrics[name] = value.get<double>();
    }
    result.reliability = json.at("reliability").get<std::string>();
    result.message = json.at("message").get<std::string>();
    return result;
  }
  result.message = end.text;
  if (end.machine) {
    result.status = "unfinished";
    return result;
  }
  result.status = end.kind == ProcessEnd::Kind::kThrew     ? "failed"
                  : end.kind == ProcessEnd::Kind::kTimeout ? "timeout"
                                                           : "crashed";
  if (result.status == "timeout") {
    result.metrics["seconds"] = result.metrics["cpu_s"] = time_limit;
  }
  return result;
}

class Experiment {
 public:
  Experiment(const ExperimentPlan& plan, const Provenance& provenance, const fs::path& folder,
             Ledger& ledger)
      : plan_(plan), provenance_(provenance), folder_(folder), ledger_(ledger) {}

  /// Runs missing trials, and with `retry` those that failed, until the program is interrupted.
  void run(bool summary_only, bool retry) {
    std::vector<Trial> all = trials_of(plan_), missing;
    std::copy_if(all.begin(), all.end(), std::back_inserter(missing), [&](const Trial& trial) {
      if (!ledger_.contains(trial)) return true;
      const TrialResult& result = ledger_.at(trial);
      return !result.finished() || (retry && result.bad());
    });
    if (missing.size() < all.size()) {
      complain("{} of {} trials have been run before\n", all.size() - missing.size(), all.size());
    }
    if (!missing.empty() && !summary_only) {
      Progress progress(missing.size());
      // Trials on one file run in sequence, so that only one graph is in memory.
      for (std::size_t begin = 0; begin < missing.size() && interrupted() == 0;) {
        std::size_t end = begin;
        while (end < missing.size() && same_file(missing[begin], missing[end])) ++end;
        run_block({missing.begin() + begin, missing.begin() + end}, progress);
        begin = end;
      }
    }
  }

 private:
  static bool same_file(const Trial& a, const Trial& b) {
    return a.graph == b.graph && a.variant == b.variant;
  }

  void run_block(const std::vector<Trial>& trials, Progress& progress) {
    std::optional<PreparedGraph> graph;
    if (!plan_.replay) {
      graph = prepare_graph(plan_.graphs.at(trials.front().source), trials.front().variant);
    }
    const auto cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    run_processes(
        trials.size(), plan_.jobs > 0 ? plan_.jobs : cores, plan_.time_limit,
        [&](std::size_t i) {
          return to_text(graph ? run_pose_graph_trial(*graph, trials[i], plan_.method_options)
                               : run_replay_trial(plan_, trials[i], provenance_, folder_));
        },
        [&](std::size_t i, const ProcessEnd& end) {
          const TrialResult result = to_result(end, plan_.time_limit);
          ledger_.append(trials[i], result);
          if (!result.finished() || result.status == "failed" || result.status == "crashed") {
            progress.message(
                fmt::format("{}: {}: {}", trials[i].key(), result.status, result.message));
          }
          progress.ended(trials[i].key());
        },
        [] { return interrupted() != 0; });
  }

  const ExperimentPlan& plan_;
  const Provenance& provenance_;
  fs::path folder_;
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
        png(reliability_image(calibration, "Inlier probabilities of " + method, kClosureClaims)));
  }
}

}  // namespace

std::string config_text(const Options& options) {
  if (options.config.empty()) {
    IniFile ini;
    read_plan(ini);
    return ini.documentation();
  }
  IniFile ini{fs::path(options.config)};
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

int run_experiment(const Options& options) {
  note_interrupts();
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

  Experiment(plan, provenance, out.folder(), ledger).run(options.summary_only, options.retry);
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
  const auto summary = summary_json(plan, provenance, counts);
  if (options.report) {
    out.write("report.html",
              report_page(trials_report_json(plan.title, ledger.text(trials_of(plan)), summary)));
  }
  const std::vector<std::string> told = out.publish(summary);
  const int code = settle(summary.contains("message") ? kExitPartial : kExitOk);
  for (const std::string& text : told) complain("hybrid-experiment: {}\n", text);
  say("{}-> {}\n", table, options.output);
  if (code != kExitOk) {
    complain("hybrid-experiment: {}: see {}\n", complaint(counts),
             (out.folder() / "results.csv").string());
  }
  return code;
}

}  // namespace hybrid
