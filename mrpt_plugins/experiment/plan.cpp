// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/experiment/plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <iterator>
#include <set>
#include <sstream>

#include "libhybrid/core/error.h"
#include "libhybrid/io/regular_file.h"
#include "mrpt_plugins/bridge/sha256.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

constexpr const char* kVariant = "{variant}";

std::vector<std::string> all_names() {
  std::vector<std::string> names;
  for (const RobustMethod& method : robust_methods()) names.push_back(method.name);
  return names;
}

/// The path of a file named in an INI: relative paths are relative to the data folder.
std::string data_path(const std::string& name, const fs::path& folder) {
  return name.empty() || fs::path(name).is_absolute() ? name : (folder / name).string();
}

void check_file(const IniSection& section, const std::string& key, const std::string& path) {
  if (!path.empty() && !fs::is_regular_file(path)) {
    section.fail(key, fmt::format("there is no file '{}'; relative names are looked for in "
                                  "[experiment] data_dir, or $HYBRID_DATA_DIR",
                                  path));
  }
}

void check_names(const IniSection& section, const std::string& key,
                 const std::vector<std::string>& names) {
  std::set<std::string> seen;
  for (const std::string& name : names) {
    if (name.find_first_of(",/\"") != std::string::npos) {
      section.fail(key, fmt::format("'{}': a name must not hold a comma, slash or quote", name));
    }
    if (!seen.insert(name).second) section.fail(key, fmt::format("names '{}' twice", name));
  }
}

GraphPlan read_graph_plan(IniFile& ini, const std::string& name, const fs::path& data) {
  IniSection section =
      ini.section(name, "A pose graph, or several whose file names hold {variant}");
  GraphPlan graph;
  graph.name = name;
  const auto file_of = [&](const char* key, const char* meaning) {
    return data_path(section.get(key, "", meaning), data);
  };
  graph.file = data_path(section.require<std::string>("file", "g2o or TORO"), data);
  graph.variants = section.get("variants", std::vector<std::string>{},
                               "what {variant} in the names of files stands for, in turn");
  graph.variant_label = section.get("variant_label", "variant", "what the variants are, for plots");
  graph.start = section.choice("start", "file", {"file", "odometry", "chordal", "tree"},
                               "as hybrid-pgo --start; file: the VERTEX lines, or chained odometry "
                               "where some are missing");
  graph.repair_information =
      section.get("repair_information", false,
                  "put the nearest positive definite matrix in the place of information that is "
                  "not");
  graph.truth = file_of("truth",
                        "true poses, as for hybrid-pgo --truth; empty: the best optimum, from all "
                        "starts, of the graph without false closures");
  graph.truth_times = file_of("truth_times", "time of each pose, for a truth with times");
  graph.labels = file_of("labels", "pairs 'i j' of poses, the true closures of the file");
  graph.label_distance =
      section.get("label_distance", 0.0,
                  "without labels: true closures are right within this distance (m) of the truth; "
                  "0: all closures of the file are true",
                  kLength);
  graph.label_angle = section.degrees("label_angle", 20.0, "and within this angle", {1e-6, 360});
  check_names(section, "variants", graph.variants);
  const bool varies = graph.file.find(kVariant) != std::string::npos;
  if (varies == graph.variants.empty()) {
    section.fail("variants", "needs {variant} in the name of the file, and the other way round");
  }
  if (graph.label_distance > 0 && graph.truth.empty()) {
    section.fail("label_distance", "needs a truth to judge closures by");
  }
  if (graph.variants.empty()) graph.variants = {""};
  for (const std::string& variant : graph.variants) {
    check_file(section, "file", with_variant(graph.file, variant));
    check_file(section, "labels", with_variant(graph.labels, variant));
  }
  check_file(section, "truth", graph.truth);
  check_file(section, "truth_times", graph.truth_times);
  return graph;
}

std::vector<ReplayPlan::Log> read_logs(IniSection& section, const fs::path& directory) {
  std::vector<ReplayPlan::Log> logs;
  std::vector<std::string> names;
  for (const std::string& file : section.get(
           "rawlogs", std::vector<std::string>{},
           "logs, each a trial of its own; empty: that of the config, or the simulated one")) {
    logs.push_back({fs::path(file).stem().string(), data_path(file, directory)});
    names.push_back(logs.back().name);
    if (!fs::is_regular_file(logs.back().path)) {
      section.fail("rawlogs", fmt::format("there is no file '{}'", logs.back().path));
    }
  }
  check_names(section, "rawlogs", names);
  if (logs.empty()) logs.push_back({});
  return logs;
}

ReplayPlan read_replay_plan(IniFile& ini, const std::string& name) {
  IniSection section = ini.section(name, "A replay; paths are relative to this file");
  ReplayPlan replay;
  replay.name = name;
  replay.config = section.path("config", "", "INI of hybrid-replay");
  replay.simulate = section.path(
      "simulate", "", "INI of hybrid-simulate: every seed simulates a log first; empty: none");
  for (const char* key : {"config", "simulate"}) {
    const std::string& path = key[0] == 'c' ? replay.config : replay.simulate;
    if (path.empty() && key[0] == 's') continue;
    if (!fs::is_regular_file(path)) {
      section.fail(key, fmt::format("there is no file '{}'", path));
    }
  }
  replay.logs = read_logs(section, ini.directory());
  if (!replay.simulate.empty() && !replay.logs.front().path.empty()) {
    section.fail("rawlogs", "are given, and 'simulate' makes others; keep one of them");
  }
  replay.maps = section.get("maps", false, "whether every trial writes OUT/maps/TRIAL.hmap");
  return replay;
}

/// Whether a name is one of those in `only`; any is where that names none.
std::function<bool(const std::string&)> read_only(IniSection& experiment,
                                                  const std::vector<std::string>& names) {
  const auto only = experiment.get("only", std::vector<std::string>{},
                                   "of the graphs or replays these alone; empty: all of them");
  for (const std::string& name : only) {
    if (std::count(names.begin(), names.end(), name) == 0) {
      experiment.fail("only",
                      fmt::format("names '{}', which is none of {}", name, fmt::join(names, ", ")));
    }
  }
  return [only](const std::string& name) {
    return only.empty() || std::count(only.begin(), only.end(), name) > 0;
  };
}

void read_sources(IniFile& ini, IniSection& experiment, ExperimentPlan& plan) {
  const bool documenting = ini.sections().empty();
  if (plan.replay) {
    const auto names = experiment.get("replays", std::vector<std::string>{},
                                      "for replays: names of their sections");
    check_names(experiment, "replays", names);
    if (names.empty()) experiment.fail("replays", "names no replay");
    const auto wanted = read_only(experiment, names);
    for (const std::string& name : names) {
      ReplayPlan replay = read_replay_plan(ini, name);
      if (wanted(name)) plan.replays.push_back(std::move(replay));
    }
    for (const std::string& name : plan.methods) {
      IniSection section = ini.section(name, "Settings of the replays under this name");
      plan.replay_variants.push_back(
          {name, section.get("set", std::vector<std::string>{},
                             "what differs from their INI files: section.key=value ...")});
    }
    return;
  }
  const char* environment = std::getenv("HYBRID_DATA_DIR");
  std::string data = experiment.path(
      "data_dir", "", "folder of the graphs; empty: $HYBRID_DATA_DIR, or else that of this file");
  if (data.empty()) data = environment != nullptr ? environment : ini.directory().string();
  const auto names = experiment.get("graphs", std::vector<std::string>{},
                                    "names of the sections that tell the graphs");
  check_names(experiment, "graphs", names);
  const auto wanted = read_only(experiment, names);
  if (documenting) return;
  if (!ini.has_section("experiment")) ini.reject_unknown();
  if (names.empty()) experiment.fail("graphs", "names no graph");
  for (const std::string& name : names) {
    GraphPlan graph = read_graph_plan(ini, name, data);
    if (wanted(name)) plan.graphs.push_back(std::move(graph));
  }
}

/// The current name of a method, given its current or deprecated name.
std::string known_method(IniSection& experiment, const std::string& given) {
  const std::string near = nearest_name(given, all_names());
  try {
    const std::string& name = robust_method(given).name;
    if (name != given) {
      experiment.warn("methods", fmt::format("names '{}', which is now called '{}'", given, name));
    }
    return name;
  } catch (const Error& e) {
    experiment.fail("methods", near.empty() ? e.what()
                                            : fmt::format("there is no method '{}'; did you mean "
                                                          "'{}'?",
                                                          given, near));
  }
}

void read_methods(IniSection& experiment, ExperimentPlan& plan) {
  plan.methods = experiment.get(
      "methods", plan.replay ? std::vector<std::string>{"replay"} : std::vector<std::string>{"gnc"},
      plan.replay ? "names of sections, each with other settings of the replays"
                  : fmt::format("what is compared: {}", fmt::join(all_names(), ", ")));
  if (plan.methods.empty()) experiment.fail("methods", "names no method");
  if (!plan.replay) {
    for (std::string& name : plan.methods) name = known_method(experiment, name);
  }
  check_names(experiment, "methods", plan.methods);
}

/// The settings except those that only add or leave out trials, and the hashes of the files.
std::map<std::string, std::string> fingerprint_of(const IniFile& ini, ExperimentPlan& plan) {
  static const std::set<std::string> kFree = {"jobs",     "rank_silence",  "trials",      "methods",
                                              "rawlogs",  "outlier_rates", "graphs",      "title",
                                              "data_dir", "variants",      "success_ate", "only"};
  std::map<std::string, std::string> settings;
  for (const auto& [section, keys] : ini.settings()) {
    for (const auto& [key, value] : keys) {
      if (kFree.count(key) == 0) settings[section + "." + key] = " " + value;
    }
  }
  Provenance files;
  const auto add = [&](const std::string& source, const std::string& path) {
    if (path.empty()) return;
    if (fs::is_regular_file(path)) check_size(path, fs::file_size(path), kLargestText);
    files.add_input(path);
    settings[source + "/" + fs::path(path).filename().string()] = "sha256 " + sha256_of_file(path);
  };
  for (const GraphPlan& graph : plan.graphs) {
    for (const std::string& variant : graph.variants) {
      add(graph.name, with_variant(graph.file, variant));
      add(graph.name, with_variant(graph.labels, variant));
    }
    add(graph.name, graph.truth);
    add(graph.name, graph.truth_times);
  }
  for (const ReplayPlan& replay : plan.replays) {
    add(replay.name, replay.config);
    add(replay.name, replay.simulate);
    for (const ReplayPlan::Log& log : replay.logs) {
      if (log.path.empty()) continue;
      files.add_input(log.path);
      settings[replay.name + "/" + log.name] = "sha256 " + sha256_of_file(log.path);
    }
  }
  plan.inputs = std::move(files.inputs);
  return settings;
}

}  // namespace

std::string with_variant(std::string text, const std::string& variant) {
  for (auto at = text.find(kVariant); at != std::string::npos; at = text.find(kVariant, at)) {
    text.replace(at, std::string(kVariant).size(), variant);
    at += variant.size();
  }
  return text;
}

std::string Trial::key() const {
  return fmt::format("{}/{}/{}/{}/{}", graph, variant, method, outlier_rate, seed);
}

ExperimentPlan read_plan(IniFile& ini) {
  ExperimentPlan plan;
  IniSection experiment = ini.section("experiment", "What is run");
  plan.replay = experiment.choice("kind", "pose_graph", {"pose_graph", "replay"},
                                  "robust pose graphs, or replays of logs") == "replay";
  plan.title = experiment.get("title", "Experiment", "heading of the plots");
  read_methods(experiment, plan);
  plan.trials = experiment.get("trials", 10, "seeds per point", {1, 100000});
  plan.first_seed = experiment.get<std::uint64_t>("first_seed", 1, "seeds are this, the next, ...");
  plan.time_limit = experiment.get("time_limit", 300.0, "seconds after which a trial is ended",
                                   kPositiveDuration);
  plan.jobs = experiment.get("jobs", 0, "trials at a time; 0: one per core", {0, 1024});
  plan.rank_silence = experiment.get(
      "rank_silence", 60.0,
      "under mpirun or srun: seconds after which a rank that says nothing is given up",
      kPositiveDuration);
  read_sources(ini, experiment, plan);
  if (plan.replay) {
    plan.fields =
        experiment.get("fields",
                       std::vector<std::string>{"objective", "cost", "truth.trajectory.rmse_m",
                                                "truth.landmarks.mean_m", "truth.class_accuracy"},
                       "what is taken from summary.json");
    plan.outlier_rates = {0.0};
  } else {
    plan.outlier_rates =
        experiment.get("outlier_rates", std::vector<double>{0.0},
                       "shares of false closures, added by the protocol of the paper", {0, 1});
    experiment.read("success_ate", plan.success_ate,
                    "a trial succeeds with a mean error of at most this (m)", kPositiveLength);
    plan.method_options = read_method_options(ini);
    plan.method_options.set_threads(1);
    for (double rate : plan.outlier_rates) {
      if (!(rate >= 0.0 && rate < 1.0)) {
        experiment.fail("outlier_rates", fmt::format("{} is not in [0, 1)", rate));
      }
    }
    if (plan.outlier_rates.empty()) experiment.fail("outlier_rates", "holds no number");
  }
  ini.reject_unknown();
  plan.fingerprint = fingerprint_of(ini, plan);
  return plan;
}

std::vector<Trial> trials_of(const ExperimentPlan& plan) {
  std::vector<Trial> trials;
  const auto add = [&](std::size_t source, const std::string& name, const std::string& variant,
                       double rate, std::uint64_t seed) {
    for (const std::string& method : plan.methods) {
      trials.push_back({source, name, variant, method, rate, seed});
    }
  };
  const auto seeds = static_cast<std::uint64_t>(plan.trials);
  for (std::size_t g = 0; g < plan.graphs.size(); ++g) {
    for (const std::string& variant : plan.graphs[g].variants) {
      for (double rate : plan.outlier_rates) {
        // Without false closures to draw, the seed has no effect.
        for (std::uint64_t s = 0; s < (rate == 0.0 ? 1 : seeds); ++s) {
          add(g, plan.graphs[g].name, variant, rate, plan.first_seed + s);
        }
      }
    }
  }
  for (std::size_t r = 0; r < plan.replays.size(); ++r) {
    for (const ReplayPlan::Log& log : plan.replays[r].logs) {
      for (std::uint64_t s = 0; s < (plan.replays[r].simulate.empty() ? 1 : seeds); ++s) {
        add(r, plan.replays[r].name, log.name, 0.0, plan.first_seed + s);
      }
    }
  }
  return trials;
}

}  // namespace hybrid
