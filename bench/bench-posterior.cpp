// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Calibration of probabilities of discrete variables, given the continuous estimate (eq. 11a) and
// with the continuous variables integrated out. Draws worlds from the model that they are estimated
// with, and compares predictions with the truth. Draws the reliability diagrams of
// docs/probabilities.md.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "bench/discrete_worlds.h"
#include "bench/stopwatch.h"
#include "libhybrid/io/write_file.h"
#include "libhybrid/marginals/discrete.h"
#include "libhybrid/marginals/posterior.h"
#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/evaluation/reliability.h"
#include "mrpt_plugins/experiment/plots.h"
#include "mrpt_plugins/output/figures.h"

namespace hybrid {
namespace {

struct Task {
  std::string name;
  ReliabilityNames names;
  std::function<bench::DiscreteWorld(int poses, int seed)> world;
};

const std::vector<Task>& tasks() {
  static const std::vector<Task> all = {
      {"modes",
       {"motions", "stated probability of slip, or of none", "observed frequency"},
       bench::slip_world},
      {"closures",
       {"loop closures", "stated probability of true, or of false", "observed frequency"},
       bench::closure_world},
      {"ranges",
       {"ranges", "stated probability of a line of sight, or of none", "observed frequency"},
       bench::range_world}};
  return all;
}

struct Counts {
  std::vector<ClassPrediction> given, integrated;
  std::size_t wrong = 0, less_probable = 0;
  double largest_error = 0, solve = 0, seconds = 0;
};

void run(const bench::DiscreteWorld& world, Counts& counts) {
  bench::Stopwatch watch;
  IncrementalSmoother smoother;
  for (const Delta& delta : world.steps) {
    const UpdateReport report = smoother.update(delta);
    if (report.status != UpdateReport::Status::kOk) throw Error(report.message);
  }
  smoother.converge();
  counts.solve += watch.elapsed().cpu;
  const Estimate estimate = smoother.estimate();
  const DiscreteMarginals given = discrete_marginals(smoother.graph(), estimate.values);
  std::vector<Key> keys;
  for (const DiscreteKey& key : world.keys) keys.push_back(key.key);
  watch = bench::Stopwatch();
  const AssignmentPosterior integrated = posterior_marginals(
      smoother.graph(), estimate, keys,
      [&](const std::vector<Key>& some) { return smoother.joint_covariance(some); });
  counts.seconds += watch.elapsed().cpu;
  for (std::size_t k = 0; k < keys.size(); ++k) {
    const auto p = given.at(keys[k]);
    const DiscreteProbabilities& q = integrated.at(keys[k]);
    counts.given.push_back({{p[0], p[1]}, world.truth[k]});
    counts.integrated.push_back({{q.p[0], q.p[1]}, world.truth[k]});
    counts.wrong += estimate.assignment.at(keys[k]) == world.truth[k] ? 0 : 1;
    counts.less_probable += (q.p[1] > q.p[0] ? 1 : 0) == world.truth[k] ? 0 : 1;
    for (double error : q.standard_error) {
      counts.largest_error = std::max(counts.largest_error, error);
    }
  }
}

void report(const Task& task, const Counts& counts, int worlds, const std::string& folder) {
  const Calibration given = calibration(counts.given);
  const Calibration integrated = calibration(counts.integrated);
  const double percent = 100.0 / static_cast<double>(counts.given.size());
  fmt::print(
      "{}: {} variables; {:.2f} % wrong in the joint estimate, {:.2f} % of the most probable "
      "values "
      "integrated\n",
      task.name, counts.given.size(), percent * counts.wrong, percent * counts.less_probable);
  fmt::print(
      "  given the estimate (eq. 11a): expected error {:.4f}, Brier {:.4f}, log loss {:.4f}\n",
      given.expected_error, given.brier, given.log_loss);
  fmt::print(
      "  integrated:                   expected error {:.4f}, Brier {:.4f}, log loss {:.4f}\n",
      integrated.expected_error, integrated.brier, integrated.log_loss);
  fmt::print(
      "  largest standard error of sampling {:.4f}; {:.1f} ms for each world, its estimate {:.1f} "
      "ms\n",
      counts.largest_error, 1e3 * counts.seconds / worlds, 1e3 * counts.solve / worlds);
  write_file(
      fmt::format("{}/reliability_{}.png", folder, task.name),
      png(side_by_side({reliability_image(given, "Given the estimate (eq. 11a)", task.names),
                        reliability_image(integrated, "Poses integrated out", task.names)})));
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) try {
  CLI::App app("Reliability of the probabilities of modes, closures and ranges");
  std::string output = "posterior";
  int worlds = 100, poses = 80, first_seed = 1;
  app.add_option("-n,--worlds", worlds, "worlds of each kind")->capture_default_str();
  app.add_option("--poses", poses, "poses of each world")->capture_default_str();
  app.add_option("--seed", first_seed, "of the first world; the others follow")
      ->capture_default_str();
  app.add_option("-o,--output", output, "folder for reliability_*.png")->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  std::filesystem::create_directories(output);
  for (const hybrid::Task& task : hybrid::tasks()) {
    hybrid::Counts counts;
    for (int k = 0; k < worlds; ++k) hybrid::run(task.world(poses, first_seed + k), counts);
    hybrid::report(task, counts, worlds, output);
  }
  return 0;
} catch (const std::exception& e) {
  fmt::print(stderr, "bench-posterior: {}\n", e.what());
  return 1;
}
