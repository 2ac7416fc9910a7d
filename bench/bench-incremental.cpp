// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// The incremental smoother on public graphs, fed pose by pose with a full estimate after each.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "bench/graph_feed.h"
#include "bench/growth_rows.h"
#include "bench/stopwatch.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/io/write_file.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/data_path.h"

namespace {

using namespace hybrid;
using namespace hybrid::bench;
using hybrid::testing::data_path;

/// A graph, and what iSAM2 (GTSAM 4.2) took for it on the same kind of machine: Gauss-Newton,
/// threshold 0.1, relinearising at every step, a full estimate after each.
struct Case {
  const char* path;
  double total_s;      // of iSAM2
  double longest_ms;   // its longest step; 0: not known
  double cost;         // after its last step
  double least_ratio;  // by which we aim to be faster; 0: no aim
};

constexpr Case kCases[] = {{"pose_graphs/CSAIL.g2o", 0.26, 8, 21.89, 10},
                           {"pose_graphs/intel.g2o", 0.59, 9, 22.53, 10},
                           {"pose_graphs/manhattan.g2o", 5.7, 48, 2293, 10},
                           {"pose_graphs_gt/manhattanOlson3500.g2o", 3.2, 0, 73.10, 0},
                           {"pose_graphs/sphere2500.g2o", 24.8, 65, 675.81, 6},
                           {"pose_graphs/parking-garage.g2o", 4.3, 55, 0.634, 10},
                           {"pose_graphs/city10000.g2o", 65, 262, 256.27, 10},
                           {"victoria_park/victoria_park_known_assoc_gtsam.txt", 22, 0, 4766, 5.5}};

/// Memory of the smoother that we aim to stay below, in sizes of its Cholesky factor.
constexpr double kMemoryLimit = 2.5;

UpdateReport checked_update(IncrementalSmoother& smoother, const Delta& delta) {
  const UpdateReport report = smoother.update(delta);
  if (report.status != UpdateReport::Status::kOk) throw Error(report.message);
  return report;
}

void print_times(const char* what, const Distribution& d) {
  std::printf("  %-5s total %8.3f s   mean %.3f  p50 %.3f  p95 %.3f  p99 %.3f  max %.3f ms\n", what,
              d.total, 1e3 * d.mean, 1e3 * d.p50, 1e3 * d.p95, 1e3 * d.p99, 1e3 * d.max);
}

double batch_optimum(const IncrementalSmoother& smoother) {
  SolverOptions options;
  options.relative_decrease = 1e-12;
  const SolverResult result = levenberg_marquardt(smoother.graph(), smoother.estimate(), options);
  return cost(smoother.graph(), result.values, smoother.assignment());
}

const char* reached(bool is) {
  return is ? "reached" : "missed";
}

/// Our figures beside those of iSAM2 and the limits set to them. Times are processor times [s].
void print_limits(const Case& peer, const Distribution& cpu, double cost) {
  const double ratio = peer.total_s / cpu.total;
  std::printf("  iSAM2 %.3g s, ratio %.1f", peer.total_s, ratio);
  if (peer.least_ratio > 0) {
    std::printf(" (limit %.3g: %s)", peer.least_ratio, reached(ratio >= peer.least_ratio));
  }
  if (peer.longest_ms > 0) {
    const double limit = peer.longest_ms / 4;
    std::printf("; longest step %.3g ms (limit %.3g: %s)", 1e3 * cpu.max, limit,
                reached(1e3 * cpu.max <= limit));
  }
  std::printf("; cost %.6g (limit %.6g: %s)\n", cost, peer.cost, reached(cost <= peer.cost));
}

/// One row of the benchmark as JSON. Adds rows of step time over graph size to `growth`.
std::string run_graph(const std::string& path, const SmootherOptions& options,
                      std::string& growth) {
  const std::vector<Step> steps = read_steps(path);
  IncrementalSmoother smoother(options);
  std::vector<double> wall, cpu;
  double eliminated = 0, pending = 0;
  for (const Step& step : steps) {
    const Stopwatch watch;
    const UpdateReport report = checked_update(smoother, to_delta(step, smoother.values()));
    const Time time = watch.elapsed();
    wall.push_back(time.wall);
    cpu.push_back(time.cpu);
    eliminated += report.eliminated;
    pending += report.pending;
  }
  const double cost = smoother.cost();
  const double memory = double(smoother.memory().bytes);
  const double factors = memory / double(sizeof(double) * smoother.tree().cliques().factor_size());
  const double optimum = batch_optimum(smoother);
  const Stopwatch watch;
  smoother.converge();
  const Time converge = watch.elapsed();
  const Distribution d = distribution(wall);
  const Distribution c = distribution(cpu);
  const std::string name = std::filesystem::path(path).stem().string();
  growth += growth_rows(name, cpu);
  std::printf("%s: %zu steps\n", name.c_str(), steps.size());
  print_times("wall", d);
  print_times("cpu", c);
  std::printf("  a step: %.1f variables eliminated, %.1f factors pending\n",
              eliminated / double(steps.size()), pending / double(steps.size()));
  std::printf(
      "  cost %.6g, converged %.6g in %.3f s (cpu %.3f), batch optimum %.6g, %.0f B per "
      "variable\n",
      cost, smoother.cost(), converge.wall, converge.cpu, optimum,
      smoother.memory().bytes_per_variable);
  std::printf("  memory %.2f MB, %.2f Cholesky factors (limit %.3g: %s)\n", 1e-6 * memory, factors,
              kMemoryLimit, reached(factors <= kMemoryLimit));
  for (const Case& peer : kCases) {
    if (std::filesystem::path(peer.path).stem() == name) print_limits(peer, c, cost);
  }
  std::fflush(stdout);
  char row[512];
  std::snprintf(row, sizeof row,
                "{\"graph\": \"%s\", \"total_s\": %.6f, \"mean_ms\": %.6f, \"p50_ms\": %.6f, "
                "\"p95_ms\": %.6f, \"p99_ms\": %.6f, \"max_ms\": %.6f, \"cost\": %.9g, "
                "\"cost_converged\": %.9g, \"batch_optimum\": %.9g, \"cpu_s\": %.6f, "
                "\"cpu_p95_ms\": %.6f}",
                name.c_str(), d.total, 1e3 * d.mean, 1e3 * d.p50, 1e3 * d.p95, 1e3 * d.p99,
                1e3 * d.max, cost, smoother.cost(), optimum, c.total, 1e3 * c.p95);
  return row;
}

void run_graphs(std::vector<std::string> graphs, const SmootherOptions& options,
                const std::string& json, const std::string& csv) {
  if (graphs.empty()) {
    for (const Case& known : kCases) graphs.push_back(data_path(known.path));
  }
  std::string text = "[", growth = kGrowthHeader;
  for (std::size_t i = 0; i < graphs.size(); ++i) {
    text += (i == 0 ? "\n  " : ",\n  ") + run_graph(graphs[i], options, growth);
  }
  if (!json.empty()) write_file(json, text + "\n]\n");
  if (!csv.empty()) write_file(csv, growth);
}

Key pose(int i) {
  return {'x', static_cast<std::uint64_t>(i)};
}

ContinuousFactorPtr between(int i, int j, const SE2& z, double sigma) {
  return std::make_shared<BetweenSE2>(pose(i), pose(j), z, Noise::isotropic(3, sigma));
}

/// The next pose of a winding path without loops.
Delta next_pose(const IncrementalSmoother& smoother, int i) {
  Delta delta;
  if (i == 0) {
    insert_first<SE2>(pose(0), delta);
    return delta;
  }
  const SE2 z(1.0, 0.0, 0.3 * std::sin(0.05 * i));
  delta.values.insert(pose(i), smoother.values().at<SE2>(pose(i - 1)) * z);
  delta.continuous.push_back(between(i - 1, i, z, 0.05));
  return delta;
}

/// Step time over the size of the graph, in blocks, and its least-squares slope.
void run_growth(int poses, const std::string& csv) {
  IncrementalSmoother smoother;
  std::string text = kGrowthHeader;
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (int block = 0; block < kGrowthBlocks; ++block) {
    const int begin = static_cast<int>(static_cast<long>(poses) * block / kGrowthBlocks);
    const int end = static_cast<int>(static_cast<long>(poses) * (block + 1) / kGrowthBlocks);
    const Stopwatch watch;
    for (int i = begin; i < end; ++i) checked_update(smoother, next_pose(smoother, i));
    const double cpu = 1e6 * watch.elapsed().cpu / (end - begin);
    text += "no loops," + std::to_string(end) + "," + std::to_string(cpu) + "\n";
    const double x = end * 1e-5;
    n += 1, sx += x, sy += cpu, sxx += x * x, sxy += x * cpu;
  }
  std::printf(
      "%d poses without loops: mean %.2f us per step (cpu), slope %.3f us per 100,000 "
      "poses, %.0f B per variable\n",
      poses, sy / n, (n * sxy - sx * sy) / (n * sxx - sx * sx),
      smoother.memory().bytes_per_variable);
  if (!csv.empty()) write_file(csv, text);
}

HybridFactorPtr closure(int number, int i, int j, const SE2& z) {
  return make_outlier_mixture({{'d', static_cast<std::uint64_t>(number)}, 2},
                              between(i, j, z, 0.05), between(i, j, z, 0.05 * std::sqrt(1e7)), 0.5,
                              0.5);
}

SE2 relative(const IncrementalSmoother& smoother, int i, int j) {
  return smoother.values().at<SE2>(pose(i)).between(smoother.values().at<SE2>(pose(j)));
}

/// Times updates that add a pose and an untrusted closure, while the first poses of the path have
/// `untouched` binary variables.
Distribution time_beside(int untouched, std::vector<double>* cpu) {
  constexpr int kPoses = 400;
  constexpr int kUpdates = 1000;
  IncrementalSmoother smoother;
  for (int i = 0; i < kPoses; ++i) checked_update(smoother, next_pose(smoother, i));
  Delta delta;
  for (int k = 0; k < untouched; ++k) {
    const int i = k % 50;
    const SE2 wrong(k % 3 == 0 ? 2.0 : 0.0, 0.0, 0.0);
    delta.hybrid.push_back(closure(k, i, i + 2, relative(smoother, i, i + 2) * wrong));
  }
  checked_update(smoother, delta);
  std::vector<double> wall;
  for (int k = 0; k < kUpdates; ++k) {
    const int i = kPoses + k;
    Delta next = next_pose(smoother, i);
    const SE2 z = relative(smoother, i - 5, i - 1);
    next.hybrid.push_back(closure(untouched + k, i - 5, i - 1, k % 4 == 0 ? z * z : z));
    const Stopwatch watch;
    checked_update(smoother, next);
    const Time time = watch.elapsed();
    wall.push_back(time.wall);
    cpu->push_back(time.cpu);
  }
  return distribution(wall);
}

void run_binary(int many) {
  for (int untouched : {10, many, 10, many}) {
    std::vector<double> cpu;
    const Distribution wall = time_beside(untouched, &cpu);
    std::printf("beside %d untouched binary variables:\n", untouched);
    print_times("wall", wall);
    print_times("cpu", distribution(cpu));
  }
}

void time_all_marginals(const std::string& path) {
  IncrementalSmoother smoother;
  for (const Step& step : read_steps(path)) {
    checked_update(smoother, to_delta(step, smoother.values()));
  }
  double trace = 0.0;
  const Stopwatch watch;
  smoother.visit_covariances(
      [&](Key, const Eigen::MatrixXd& covariance) { trace += covariance.trace(); });
  const Time time = watch.elapsed();
  std::printf("%s: covariances of all %zu poses in %.3f s (cpu %.3f), sum of traces %.6g\n",
              std::filesystem::path(path).stem().c_str(), smoother.values().size(), time.wall,
              time.cpu, trace);
}

/// Times the joint covariance of the newest pose and the five landmarks seen last after every step.
void time_online_marginals(const std::string& path) {
  IncrementalSmoother smoother;
  std::deque<Key> landmarks;
  std::vector<double> wall, cpu;
  for (const Step& step : read_steps(path)) {
    checked_update(smoother, to_delta(step, smoother.values()));
    Key newest = step.front().to;
    for (const Measurement& m : step) {
      if (!std::holds_alternative<Eigen::Vector2d>(m.measured)) continue;
      newest = m.from;
      if (std::find(landmarks.begin(), landmarks.end(), m.to) != landmarks.end()) continue;
      landmarks.push_back(m.to);
      if (landmarks.size() > 5) landmarks.pop_front();
    }
    if (landmarks.size() < 5) continue;
    std::vector<Key> keys = {newest};
    keys.insert(keys.end(), landmarks.begin(), landmarks.end());
    const Stopwatch watch;
    smoother.joint_covariance(keys);
    const Time time = watch.elapsed();
    wall.push_back(time.wall);
    cpu.push_back(time.cpu);
  }
  const Distribution w = distribution(wall);
  const Distribution c = distribution(cpu);
  std::printf(
      "%s: newest pose with five landmarks, %zu times: wall median %.1f p95 %.1f us, cpu "
      "median %.1f p95 %.1f us\n",
      std::filesystem::path(path).stem().c_str(), wall.size(), 1e6 * w.p50, 1e6 * w.p95,
      1e6 * c.p50, 1e6 * c.p95);
}

void run_marginals() {
  time_all_marginals(data_path("pose_graphs_gt/manhattanOlson3500.g2o"));
  time_all_marginals(data_path("pose_graphs/city10000.g2o"));
  time_online_marginals(data_path("victoria_park/victoria_park_known_assoc_gtsam.txt"));
}

}  // namespace

int main(int argc, char** argv) try {
  CLI::App app(
      "The incremental smoother on graphs, fed pose by pose with a full estimate after each: time "
      "per "
      "step and final cost");
  std::vector<std::string> graphs;
  std::string json, csv;
  SmootherOptions options;
  int growth = 0, binary = 0;
  bool marginals = false;
  app.add_option("GRAPH", graphs, "g2o or TORO files; the public ones by default");
  app.add_option("--json", json, "Write the figures of the graphs here, too");
  app.add_option("--defer", options.defer, "SmootherOptions::defer: how long new factors wait")
      ->check(CLI::NonNegativeNumber);
  app.add_option("--csv", csv, "Write the time per step against the size; plot-growth draws it");
  app.add_option("--growth", growth, "Instead: an exploration of so many poses without loops")
      ->check(CLI::PositiveNumber);
  app.add_option("--binary", binary, "Instead: an update beside so many unaffected variables")
      ->check(CLI::PositiveNumber);
  app.add_flag("--marginals", marginals, "Instead: covariances after and during a run");
  CLI11_PARSE(app, argc, argv);
  if (growth > 0) run_growth(growth, csv);
  if (binary > 0) run_binary(binary);
  if (marginals) run_marginals();
  if (growth == 0 && binary == 0 && !marginals) run_graphs(graphs, options, json, csv);
  return EXIT_SUCCESS;
} catch (const std::exception& e) {
  std::fprintf(stderr, "bench-incremental: %s\n", e.what());
  return EXIT_FAILURE;
}
