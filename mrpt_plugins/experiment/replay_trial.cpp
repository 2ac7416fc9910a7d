// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/replay_trial.h"

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/experiment/processes.h"
#include "mrpt_plugins/job/replay.h"
#include "mrpt_plugins/simulation/simulator.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

/// The key as a name of a folder.
std::string folder_name(std::string key) {
  for (char& c : key) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-') c = '_';
  }
  return key;
}

/// Simulates a scenario with this seed: writes the log and its ground truth.
void simulate_log(const std::string& config, std::uint64_t seed, const fs::path& log) {
  IniFile ini{fs::path(config)};
  ini.override_value("simulation", "seed", std::to_string(seed));
  const Scenario scenario = read_scenario(ini);
  ini.reject_unknown();
  write_simulation(simulate(scenario), scenario, log.string());
}

/// The map file of a trial, which does not exist: a trial that is run again starts a new map.
fs::path new_map(const fs::path& output, const std::string& key) {
  const fs::path map = output / "maps" / (folder_name(key) + ".hmap");
  fs::create_directories(map.parent_path());
  for (const char* journal : {"", "-journal", "-wal", "-shm"}) fs::remove(map.string() + journal);
  return map;
}

/// Replays; throws MachineFault if a fault of the machine made it fail.
ReplayOutcome replay_or_fault(const ReplayRequest& request) {
  try {
    return replay(request);
  } catch (const Error& e) {
    if (is_machine_fault(e.what())) throw MachineFault(e.what());
    throw;
  }
}

/// The value at a path such as "truth.trajectory.rmse_m"; null if there is none.
const nlohmann::json* find(const nlohmann::json& root, const std::string& path) {
  const nlohmann::json* at = &root;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    const auto it = at->is_object() ? at->find(path.substr(begin, end - begin)) : at->end();
    if (!at->is_object() || it == at->end()) return nullptr;
    at = &*it;
    begin = end + 1;
  }
  return at->is_number() ? at : nullptr;
}

}  // namespace

std::vector<std::string> replay_metrics(const ExperimentPlan& plan) {
  std::vector<std::string> names = {"seconds", "total_s", "keyframes", "landmarks"};
  for (const std::string& field : plan.fields) {
    if (std::find(names.begin(), names.end(), field) == names.end()) names.push_back(field);
  }
  return names;
}

TrialResult run_replay_trial(const ExperimentPlan& plan, const Trial& trial,
                             const Provenance& provenance, const fs::path& output) {
  const ReplayPlan& planned = plan.replays.at(trial.source);
  const fs::path folder = output / "trials" / folder_name(trial.key());
  fs::create_directories(folder);
  ReplayRequest request;
  request.provenance.version = provenance.version;
  request.provenance.command = provenance.command;
  request.config = planned.config;
  request.output = folder.string();
  request.pictures = false;
  const fs::path log = folder / "simulated.rawlog";
  if (!planned.simulate.empty()) {
    simulate_log(planned.simulate, trial.seed, log);
    request.rawlog = log.string();
    request.truth_map = (folder / "simulated_ground_truth.txt").string();
    request.truth_path = (folder / "simulated_ground_truth_robot_path.txt").string();
  }
  for (const ReplayPlan::Log& given : planned.logs) {
    if (given.name == trial.variant && !given.path.empty()) request.rawlog = given.path;
  }
  if (planned.maps) request.map = new_map(output, trial.key()).string();
  for (const ReplayVariant& variant : plan.replay_variants) {
    if (variant.name == trial.method) request.settings = variant.settings;
  }
  const fs::path fixes = folder / "simulated_ground_truth_fixes.csv";
  if (!planned.simulate.empty() && fs::exists(fixes)) {
    request.settings.push_back("log.truth_fixes=" + fixes.string());
  }
  const Summary summary = replay_or_fault(request).summary;
  fs::remove(log);
  const nlohmann::json json = summary_json(summary);
  TrialResult result;
  for (const std::string& name : replay_metrics(plan)) {
    const auto* value = find(json, name == "seconds" ? "solver_s" : name);
    if (value != nullptr) result.metrics[name] = value->get<double>();
  }
  if (summary.status != "ok") {
    result.status = "partial";
    result.message = summary.message;
  }
  return result;
}

}  // namespace hybrid
