// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Calibration of the class probabilities of a map. Simulates a classed world with many seeds, maps
// each log, and compares the class probabilities of each landmark after its first few sightings
// with its true class. Draws the reliability diagram of docs/classes.md.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "libhybrid/io/write_file.h"
#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/evaluation/reliability.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/output/figures.h"
#include "mrpt_plugins/simulation/scenario.h"
#include "mrpt_plugins/simulation/simulator.h"

namespace hybrid {
namespace {

namespace fs = std::filesystem;

struct Counts {
  std::vector<ClassPrediction> early;    ///< after 1, 2, 3 and 5 sightings
  std::size_t landmarks = 0, right = 0;  ///< at the end, of those seen five times
};

bool is_early(int sightings) {
  return sightings == 1 || sightings == 2 || sightings == 3 || sightings == 5;
}

/// Adds the predictions of all landmarks that have just been sighted for the 1st, 2nd, ... time.
void collect(const Mapper& mapper, const std::map<std::int64_t, int>& true_class,
             std::map<std::int64_t, int>& sightings, Counts& counts) {
  for (const auto& [id, landmark] : mapper.landmarks()) {
    int& before = sightings[id];
    if (landmark.sightings == before) continue;
    before = landmark.sightings;
    if (!is_early(before)) continue;
    const Uncertainty stated = mapper.backend().uncertainty({}, {*landmark.class_key});
    counts.early.push_back({stated.probabilities.at(landmark.class_key->key), true_class.at(id)});
  }
}

void run(const std::string& config, int seed, const std::string& log, Counts& counts) {
  IniFile world{fs::path(config)};
  world.override_value("simulation", "seed", std::to_string(seed));
  const Scenario scenario = read_scenario(world);
  const Simulation simulation = simulate(scenario);
  write_simulation(simulation, scenario, log);
  std::map<std::int64_t, int> true_class, sightings;
  for (const auto& landmark : simulation.landmarks) {
    true_class[landmark.id] = static_cast<int>(landmark.class_index);
  }

  IniFile ini("", "(defaults)");
  KeyframeSource source(log, read_source_options(ini));
  Mapper mapper(read_motion_options(ini), {make_plugin("ClassedBearingRangeKnownIds", ini)},
                make_backend(ini.section("solver")), source.is_3d());
  while (const auto keyframe = source.next()) {
    mapper.add(*keyframe);
    collect(mapper, true_class, sightings, counts);
  }
  mapper.finish();
  for (const LandmarkEstimate& landmark : mapper.result().landmarks) {
    if (landmark.sightings < 5) continue;
    ++counts.landmarks;
    if (landmark.class_index == true_class.at(landmark.id)) ++counts.right;
  }
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) try {
  CLI::App app("Reliability of class probabilities over simulated logs");
  std::string config = "config/simulate_classed_demo.ini", output = "calibration";
  int seeds = 20;
  app.add_option("-c,--config", config, "world to simulate")->capture_default_str();
  app.add_option("-n,--seeds", seeds, "number of logs, with seeds 1, 2, ...")
      ->capture_default_str();
  app.add_option("-o,--output", output, "folder for reliability.png")->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  const std::string log =
      (hybrid::fs::temp_directory_path() / fmt::format("calibration_{}.rawlog", getpid())).string();
  hybrid::Counts counts;
  for (int seed = 1; seed <= seeds; ++seed) hybrid::run(config, seed, log, counts);
  for (const char* end : {".rawlog", "_ground_truth.txt", "_ground_truth_robot_path.txt"}) {
    hybrid::fs::remove(log.substr(0, log.rfind('.')) + end);
  }
  const hybrid::Calibration result = hybrid::calibration(counts.early);
  std::filesystem::create_directories(output);
  hybrid::write_file(output + "/reliability.png",
                     hybrid::png(hybrid::reliability_image(
                         result, fmt::format("Class probabilities, {} simulated logs", seeds))));
  fmt::print("{} predictions: expected calibration error {:.4f}, Brier {:.4f}, log loss {:.4f}\n",
             result.predictions, result.expected_error, result.brier, result.log_loss);
  fmt::print("{} of {} landmarks seen at least five times have the right class at the end\n",
             counts.right, counts.landmarks);
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "bench-calibration: {}\n", e.what());
  return 1;
}
