// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Results of Levenberg-Marquardt on graphs with known optimum: from odometry alone, and from the
// best of all cheap starts, without poses in the file and with scrambled ones. Arguments: number of
// seeds (3), further graphs to read.
#include <cstdio>
#include <cstdlib>

#include "libhybrid/io/read_graph.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "libhybrid/solvers/starts.h"
#include "tests/support/pose_graph_worlds.h"

namespace {

using namespace hybrid;

SolverOptions options() {
  SolverOptions options;
  options.relative_decrease = 1e-9;
  return options;
}

SolverReport alone(const PoseGraph& graph, const Values& initial) {
  return levenberg_marquardt(HybridGraph(to_factors(graph, initial)), {initial, {}}, options())
      .report;
}

void chosen(const PoseGraph& graph, const char* name, const Values& initial) {
  const std::vector<ContinuousFactorPtr> factors = to_factors(graph, initial);
  const StartsResult result = solve_from_starts(
      HybridGraph(factors), pose_graph_starts(graph, factors, name, initial), options());
  std::printf(" %10.6g %-8s %6.3f s", result.report.final_cost(),
              result.trials[result.won].name.c_str(), result.report.seconds);
}

void print(const char* name, worlds::World world, unsigned seed) {
  const Values odometry = initialize_from_odometry(world.graph);
  const SolverReport from_odometry = alone(world.graph, odometry);
  std::printf("%-10s %4u %10.6g %10.6g %6.3f s", name, seed,
              alone(world.graph, world.truth).final_cost(), from_odometry.final_cost(),
              from_odometry.seconds);
  chosen(world.graph, "odometry", odometry);
  scramble(world, seed);
  chosen(world.graph, "file", world.graph.values);
  std::printf("\n");
}

}  // namespace

int main(int argc, char** argv) {
  const unsigned seeds = argc > 1 ? static_cast<unsigned>(std::atoi(argv[1])) : 3;
  std::printf(
      "graph      seed    planted   odometry alone   default, no poses   scrambled poses\n");
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    print("sphere", worlds::sphere(20, 40, {0.1, 0.3}, seed), seed);
    print("torus", worlds::torus(25, 30, {0.1, 0.3}, seed), seed);
    print("grid", worlds::grid3(8, 0.7, {0.1, 0.3}, seed), seed);
    print("town", worlds::town(800, 8, 0.3, {0.05, 0.1}, seed), seed);
    print("building", worlds::building(4, 40, {0.1, 0.1}, {0.05, 0.02}, seed), seed);
  }
  for (int i = 2; i < argc; ++i) {
    const PoseGraph graph = read_graph(argv[i]);
    const Values odometry = initialize_from_odometry(graph);
    const SolverReport from_odometry = alone(graph, odometry);
    std::printf("%s: odometry %.6g %.4f s, default", argv[i], from_odometry.final_cost(),
                from_odometry.seconds);
    chosen(graph, "odometry", odometry);
    if (graph.values.size() == odometry.size()) {
      const SolverReport from_file = alone(graph, graph.values);
      std::printf("; file %.6g %.4f s, default", from_file.final_cost(), from_file.seconds);
      chosen(graph, "file", graph.values);
    }
    std::printf("\n");
  }
}
