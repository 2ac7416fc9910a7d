// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include "libhybrid/pose_graph/false_closures.h"
#include "libhybrid/selection/closure_selection.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/pose_graph_worlds.h"

namespace hybrid {
namespace {

/// The cost with all true closures, from the truth.
double planted_cost(const worlds::World& world) {
  const HybridGraph graph(to_factors(world.graph, world.truth));
  return levenberg_marquardt(graph, {world.truth, {}}).report.final_cost();
}

TEST(FoldedMap, SelectionEndsInThePlantedOptimum) {
  for (const unsigned seed : {1u, 2u}) {
    const worlds::World world = worlds::torus(25, 30, {0.1, 0.3}, seed);
    const Values start = initialize_from_odometry(world.graph);
    const RobustResult result = select_closures(to_robust_problem(world.graph, start));
    EXPECT_NEAR(result.cost, planted_cost(world), 1e-3 * result.cost) << "seed " << seed;
    for (std::size_t k = 1; k < result.objectives.size(); ++k) {
      EXPECT_LT(result.objectives[k], result.objectives[k - 1]);
    }
  }
}

TEST(FoldedMap, FalseClosuresStayOut) {
  const worlds::World world = worlds::torus(12, 20, {0.1, 0.2}, 3);
  const PoseGraph graph = add_false_closures(world.graph, 0.3, 4);
  const Values start = initialize_from_odometry(graph);
  const RobustProblem problem = to_robust_problem(graph, start);
  const RobustResult result = select_closures(problem);
  const std::size_t good = to_robust_problem(world.graph, start).closures.size();
  for (std::size_t k = good; k < result.decisions.size(); ++k) {
    EXPECT_FALSE(result.decisions[k].accepted()) << k;
  }
}

}  // namespace
}  // namespace hybrid
