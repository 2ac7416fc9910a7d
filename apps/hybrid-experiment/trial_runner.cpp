// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-experiment/trial_runner.h"

#include <nlohmann/json.hpp>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/experiment/processes.h"
#include "mrpt_plugins/experiment/replay_trial.h"

namespace hybrid {
namespace {

TrialResult to_result(const ProcessEnd& end, double time_limit) {
  if (end.kind == ProcessEnd::Kind::kDone) return result_of_text(end.text);
  TrialResult result;
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

}  // namespace

std::string result_text(const TrialResult& result) {
  nlohmann::json json;
  json["status"] = result.status;
  json["metrics"] = result.metrics;
  json["reliability"] = result.reliability;
  json["message"] = result.message;
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

TrialResult result_of_text(const std::string& text) {
  TrialResult result;
  const auto json = nlohmann::json::parse(text);
  result.status = json.at("status").get<std::string>();
  for (const auto& [name, value] : json.at("metrics").items()) {
    if (value.is_number()) result.metrics[name] = value.get<double>();
  }
  result.reliability = json.at("reliability").get<std::string>();
  result.message = json.at("message").get<std::string>();
  return result;
}

void TrialRunner::prepare(const Trial& trial) {
  if (plan_.replay || prepared_ == std::pair(trial.graph, trial.variant)) return;
  prepared_ = {};
  graph_.reset();
  fault_.clear();
  try {
    graph_ = prepare_graph(plan_.graphs.at(trial.source), trial.variant);
  } catch (const Error& e) {
    if (is_machine_fault(e.what())) throw;
    fault_ = e.what();
  }
  prepared_ = {trial.graph, trial.variant};
}

void TrialRunner::run(const std::vector<Trial>& trials, int jobs, const Done& done,
                      const Stop& stop) const {
  if (!fault_.empty()) {
    TrialResult failed;
    failed.status = "failed";
    failed.message = fault_;
    for (const Trial& trial : trials) done(trial, failed);
    return;
  }
  run_processes(
      trials.size(), jobs, plan_.time_limit,
      [&](std::size_t i) {
        return result_text(graph_ ? run_pose_graph_trial(*graph_, trials[i], plan_.method_options)
                                  : run_replay_trial(plan_, trials[i], provenance_, folder_));
      },
      [&](std::size_t i, const ProcessEnd& end) {
        done(trials[i], to_result(end, plan_.time_limit));
      },
      stop);
}

}  // namespace hybrid
