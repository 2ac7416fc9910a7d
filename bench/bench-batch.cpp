// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Batch Levenberg-Marquardt compared with Ceres: same residuals and Jacobians, same initial values,
// in one run.
#include <ceres/ceres.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include "bench/ceres_factor.h"
#include "libhybrid/core/elapsed.h"
#include "libhybrid/io/read_graph.h"
#include "libhybrid/io/write_file.h"
#include "libhybrid/linear/cholesky.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/data_path.h"

namespace hybrid {
namespace {

constexpr int kThreads = 2;
constexpr double kFunctionTolerance = 1e-6;

using bench::CeresFactor;
using bench::Retraction;
using Clock = std::chrono::steady_clock;

double median(std::vector<double> x) {
  std::nth_element(x.begin(), x.begin() + x.size() / 2, x.end());
  return x[x.size() / 2];
}

struct Case {
  std::string name;
  HybridGraph graph;
  Estimate initial;
};

Case load(const std::string& argument) {
  std::string path = argument;
  if (!std::filesystem::exists(path)) {
    path = testing::data_path("pose_graphs/" + argument);
    if (!std::filesystem::exists(path)) path += ".g2o";
  }
  const PoseGraph file = read_graph(path);
  Case result;
  result.name = std::filesystem::path(path).stem();
  result.initial.values = file.values.empty() ? initialize_from_odometry(file) : file.values;
  for (auto& factor : to_factors(file, result.initial.values)) result.graph.add(std::move(factor));
  return result;
}

struct Outcome {
  double seconds = 0.0;
  double cost = 0.0;
  int iterations = 0;
};

/// Times Solve only, without building the problem of Ceres.
Outcome run_ceres(const Case& c) {
  Values values = c.initial.values;
  ceres::Problem problem;
  for (Key key : values.keys()) {
    const VariableType type = values.type(key);
    problem.AddParameterBlock(values.data(values.slot(key)), type.size, new Retraction(type));
  }
  c.graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) {
    std::vector<double*> x;
    for (Key key : factor->keys()) x.push_back(values.data(values.slot(key)));
    problem.AddResidualBlock(new CeresFactor(factor), nullptr, x);
  });
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  options.num_threads = kThreads;
  options.max_num_iterations = 200;
  options.function_tolerance = kFunctionTolerance;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  const auto start = Clock::now();
  ceres::Solve(options, &problem, &summary);
  return {seconds_since(start), summary.final_cost,
          static_cast<int>(summary.iterations.size()) - 1};
}

/// Times everything from the graph to the values, compilation and ordering included.
Outcome run_ours(const Case& c) {
  SolverOptions options;
  options.threads = kThreads;
  options.relative_decrease = kFunctionTolerance;
  const auto start = Clock::now();
  const SolverResult result = levenberg_marquardt(c.graph, c.initial, options);
  return {seconds_since(start), result.report.final_cost(), result.report.iterations};
}

/// Time of one of our iterations divided by that of CHOLMOD's numeric factorisation of the same
/// matrix.
double iteration_over_cholmod(const Case& c, int repeats) {
  Problem problem(c.graph, c.initial.values, c.initial.assignment, kThreads);
  Problem::State state = problem.load(c.initial.values);
  Problem::State moved;
  problem.linearize(state);
  problem.assemble();
  NormalEquations& system = problem.system();
  Cholesky cholmod(system.matrix());
  std::vector<double> step(system.scalars());
  std::vector<double> ours, theirs;
  for (int k = 0; k < repeats; ++k) {
    auto start = Clock::now();
    cholmod.factorize(system.matrix());
    theirs.push_back(seconds_since(start));
    start = Clock::now();
    problem.linearize(state);
    problem.assemble();
    problem.factorize(0.0);
    step = system.gradient();
    system.solve(step.data());
    problem.retract(state, step.data(), moved);
    ours.push_back(seconds_since(start));
  }
  return median(ours) / median(theirs);
}

std::string measure(const Case& c, int repeats) {
  std::vector<double> ours, theirs;
  Outcome mine, other;
  for (int k = 0; k < repeats; ++k) {
    mine = run_ours(c);
    other = run_ceres(c);
    ours.push_back(mine.seconds);
    theirs.push_back(other.seconds);
  }
  const double ours_s = median(ours);
  const double ceres_s = median(theirs);
  char line[400];
  std::snprintf(line, sizeof line,
                "{\"graph\": \"%s\", \"ours_s\": %.6f, \"ceres_s\": %.6f, \"ratio\": %.3f, "
                "\"cost_ours\": %.9g, \"cost_ceres\": %.9g, \"iteration_over_cholmod\": %.3f, "
                "\"iterations_ours\": %d, \"iterations_ceres\": %d}",
                c.name.c_str(), ours_s, ceres_s, ceres_s / ours_s, mine.cost, other.cost,
                iteration_over_cholmod(c, 2 * repeats + 1), mine.iterations, other.iterations);
  return line;
}

void run(std::vector<std::string> graphs, int repeats, const std::string& json) {
  if (graphs.empty()) {
    graphs = {"intel", "CSAIL", "manhattan", "sphere2500", "parking-garage", "city10000"};
  }
  std::string all;
  for (const std::string& graph : graphs) {
    const std::string line = measure(load(graph), repeats);
    std::cout << line << std::endl;
    all += (all.empty() ? "[" : ",\n ") + line;
  }
  if (!json.empty()) write_file(json, all + "]\n");
}

}  // namespace
}  // namespace hybrid

int main(int argc, char** argv) try {
  CLI::App app("Batch Levenberg-Marquardt and Ceres in turn, from the same initial values");
  std::vector<std::string> graphs;
  int repeats = 5;
  std::string json;
  app.add_option("GRAPH", graphs, "g2o or TORO files, or names in $HYBRID_DATA_DIR/pose_graphs");
  app.add_option("--repeats", repeats, "The figures are medians of so many runs")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--json", json, "Write the figures here, too");
  CLI11_PARSE(app, argc, argv);
  hybrid::run(std::move(graphs), repeats, json);
  return EXIT_SUCCESS;
} catch (const std::exception& e) {
  std::fprintf(stderr, "bench-batch: %s\n", e.what());
  return EXIT_FAILURE;
}
