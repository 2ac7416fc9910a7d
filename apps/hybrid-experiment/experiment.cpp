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
#include "libhybrid/core/error.h"
#include "mrpt_plugins/experiment/ledger.h"
#include "mrpt_plugins/experiment/plots.h"
#include "mrpt_plugins/experiment/pose_graph_trial.h"
#include "mrpt_plugins/experiment/processes.h"
#include "mrpt_plugins/experiment/replay_trial.h"
#include "mrpt_plugins/experiment/statistics.h"
#include "mrpt_plugins/output/figures.h"
#include "mrpt_plugins/output/output_directory.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

constexpr const char* kSettings = "settings.txt";

void apply(const Options& options, IniFile& ini) {
  if (!options.data_dir.empty()) {
    ini.override_value("experiment", "data_dir", fs::absolute(options.data_dir).string());
  }
  if (options.jobs > 0) {
    ini.override_value("experiment", "jobs", std::to_string(options.jobs));
  }
}

/// Throws Error where the folder has results of other settings; else notes the settings. What is
/// only in one of the two belongs to graphs or methods that were added or left out.
void check_settings(const OutputDirectory& out, const ExperimentPlan& plan) {
  std::map<std::string, std::string> all = plan.fingerprint;
  std::ifstream in(out.folder() / kSettings);
  for (std::string line; std::getline(in, line);) {
    const std::size_t equals = line.find('=');
    if (equals == std::string::npos) continue;
    const std::string name = line.substr(0, equals), before = line.substr(equals + 1);
    const auto it = all.emplace(name, before).first;
    if (it->second != before) {
      throw Error(
          fmt::format("{}: the results there are of other settings: {} was '{}' and is now "
                      "'{}'; use another -o, or remove the folder",
                      out.folder().string(), name, before, it->second));
    }
  }
  std::string text;
  for (const auto& [name, value] : all) text += fmt::format("{}={}\n", name, value);
  out.write(kSettings, text);
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
  Experiment(const ExperimentPlan& plan, const fs::path& programs, const OutputDirectory& out,
             Ledger& ledger)
      : plan_(plan), programs_(programs), out_(out), ledger_(ledger) {}

  /// Runs what is missing; returns how many trials of the plan failed.
  std::size_t run(bool summary_only) {
    std::vector<Trial> all = trials_of(plan_), missing;
    std::copy_if(all.begin(), all.end(), std::back_inserter(missing),
                 [&](const Trial& trial) { return !ledger_.contains(trial); });
    if (missing.size() < all.size()) {
      fmt::print(stderr, "{} of {} trials have been run before\n", all.size() - missing.size(),
                 all.size());
    }
    if (!missing.empty() && !summary_only) {
      Progress progress(missing.size());
      // Trials on one file follow each other, so only one graph is in memory.
      for (std::size_t begin = 0; begin < missing.size();) {
        std::size_t end = begin;
        while (end < missing.size() && same_file(missing[begin], missing[end])) ++end;
        run_block({missing.begin() + begin, missing.begin() + end}, progress);
        begin = end;
      }
    }
    return static_cast<std::size_t>(std::count_if(all.begin(), all.end(), [&](const Trial& trial) {
      if (!ledger_.contains(trial)) return false;
      const std::string& status = ledger_.at(trial).status;
      return status == "failed" || status == "crashed";
    }));
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
                               : run_replay_trial(plan_, trials[i], programs_, out_.folder()));
        },
        [&](std::size_t i, const ProcessEnd& end) {
          const TrialResult result = to_result(end, plan_.time_limit);
          ledger_.append(trials[i], result);
          if (result.status == "failed" || result.status == "crashed") {
            progress.message(
                fmt::format("{}: {}: {}", trials[i].key(), result.status, result.message));
          }
          progress.ended(trials[i].key());
        });
  }

  const ExperimentPlan& plan_;
  fs::path programs_;
  const OutputDirectory& out_;
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

int run_experiment(const Options& options, const fs::path& program) {
  IniFile ini{fs::path(options.config)};
  apply(options, ini);
  const ExperimentPlan plan = read_plan(ini);
  const OutputDirectory out(options.output);
  Ledger ledger(out.folder(), plan.replay ? replay_metrics(plan) : pose_graph_metrics());
  check_settings(out, plan);
  out.write("experiment.ini", ini.documentation());

  const std::size_t failed =
      Experiment(plan, program.parent_path(), out, ledger).run(options.summary_only);
  const std::vector<PointSummary> points = summarize(plan, ledger);
  const std::string table = summary_table(plan, points, ledger.metrics());
  out.write("summary.csv", summary_csv(points, ledger.metrics()));
  out.write("summary.txt", table);
  draw(plan, ledger, points, out);
  out.write("results.csv", ledger.text(trials_of(plan)));
  fmt::print("{}-> {}\n", table, out.folder().string());
  if (failed == 0) return kExitOk;
  fmt::print(stderr, "hybrid-experiment: {} trials failed, see {}\n", failed,
             (out.folder() / "results.csv").string());
  return kExitPartial;
}

}  // namespace hybrid
