// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/replay_trial.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <csignal>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/experiment/processes.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

std::string last_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line, last;
  while (std::getline(in, line)) {
    if (!line.empty()) last = line;
  }
  return last;
}

/// Runs one of our programs; returns its exit code, 0 or `partial`. What else it returns becomes an
/// Error with the last line of its output.
int run_ours(const std::vector<std::string>& arguments, const fs::path& log, int partial) {
  const int code = run_program(arguments, log.string());
  if (code == 0 || code == partial) return code;
  constexpr int kInterrupted = 128;  // plus the signal
  const std::string why = last_line(log);
  if (is_machine_fault(why) || (code > kInterrupted && is_from_outside(code - kInterrupted))) {
    throw MachineFault(why);
  }
  throw Error(why);
}

/// A name for a folder.
std::string folder_name(std::string key) {
  for (char& c : key) {
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '.' && c != '-') c = '_';
  }
  return key;
}

/// The number at a path such as "truth.trajectory.rmse_m"; nothing if there is none.
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
                             const fs::path& programs, const fs::path& output) {
  constexpr int kPartial = 2;  // exit code of hybrid-replay for a damaged log
  const ReplayPlan& replay = plan.replays.at(trial.source);
  const fs::path folder = output / "trials" / folder_name(trial.key());
  fs::create_directories(folder);
  std::vector<std::string> arguments = {(programs / "hybrid-replay").string(),
                                        "-c",
                                        replay.config,
                                        "--no-pictures",
                                        "-o",
                                        folder.string()};
  const fs::path log = folder / "simulated.rawlog";
  if (!replay.simulate.empty()) {
    run_ours({(programs / "hybrid-simulate").string(), "-c", replay.simulate, "--seed",
              std::to_string(trial.seed), "-o", log.string()},
             folder / "simulate.log", 0);
    const auto beside = [&](const char* ending) { return (folder / ending).string(); };
    for (const std::string& argument :
         {std::string("--rawlog"), log.string(), std::string("--truth-map"),
          beside("simulated_ground_truth.txt"), std::string("--truth-path"),
          beside("simulated_ground_truth_robot_path.txt")}) {
      arguments.push_back(argument);
    }
  }
  for (const ReplayVariant& variant : plan.replay_variants) {
    if (variant.name != trial.method) continue;
    for (const std::string& setting : variant.settings) {
      arguments.emplace_back("--set");
      arguments.push_back(setting);
    }
  }
  const int code = run_ours(arguments, folder / "replay.log", kPartial);
  fs::remove(log);
  std::ifstream in(folder / "summary.json");
  const nlohmann::json summary = nlohmann::json::parse(in, nullptr, false);
  if (summary.is_discarded()) throw Error((folder / "summary.json").string() + ": is not JSON");
  TrialResult result;
  for (const std::string& name : replay_metrics(plan)) {
    const auto* value = find(summary, name == "seconds" ? "solver_s" : name);
    if (value != nullptr) result.metrics[name] = value->get<double>();
  }
  if (code == kPartial) {
    result.status = "partial";
    result.message = summary.value("message", "");
  }
  return result;
}

}  // namespace hybrid
