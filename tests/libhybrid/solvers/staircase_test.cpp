// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/solvers/certificate.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/pose_graph_worlds.h"

namespace hybrid {
namespace {

using worlds::World;

/// What Levenberg-Marquardt finds from some poses, and what the staircase makes of that.
struct Climb : StaircaseResult {
  double stated_cost = 0.0;  // of the values that it returns
};

Climb climb_from(const PoseGraph& graph, const Values& start) {
  const std::vector<ContinuousFactorPtr> factors = to_factors(graph, start);
  const HybridGraph all(factors);
  SolverOptions options;
  options.max_iterations = 60;
  options.threads = 1;
  const SolverResult found = levenberg_marquardt(all, {start, {}}, options);
  const StaircaseResult climbed = climb_staircase(factors, found.values);
  EXPECT_NEAR(climbed.cost_before, cost(all, found.values, {}), 1e-9 * climbed.cost_before + 1e-12);
  return {climbed, cost(all, climbed.values, {})};
}

TEST(Staircase, FindsThePlantedOptimumFromScrambledPoses) {
  constexpr unsigned kGraphs = 100;
  int before = 0, after = 0, verified = 0;
  for (unsigned k = 0; k < kGraphs; ++k) {
    World world = worlds::small_world(k, 0.05 * (k % 5));
    const Climb planted = climb_from(world.graph, world.truth);
    scramble(world, k);
    const Climb climbed = climb_from(world.graph, world.graph.values);
    EXPECT_LE(climbed.stated_cost, climbed.cost_before * (1.0 + 1e-9)) << "graph " << k;
    EXPECT_NEAR(climbed.stated_cost, climbed.cost, 1e-6 * climbed.cost) << "graph " << k;
    const double optimum = planted.stated_cost * (1.0 + 1e-4);
    before += climbed.cost_before <= optimum;
    after += climbed.stated_cost <= optimum;
    verified += climbed.certificate.verified;
    if (climbed.certificate.verified) {
      EXPECT_LE(climbed.stated_cost, planted.stated_cost * (1.0 + 1e-3)) << "graph " << k;
    }
  }
  // A random start ends in a local minimum more often than not; the staircase leaves it.
  EXPECT_LT(before, 50);
  EXPECT_GE(after, 95);
  EXPECT_GE(verified, 80);
}

/// Twelve steps of 30 degrees in a circle, estimated as if they had been of other angles.
Values wound(int windings) {
  Values values;
  for (int i = 0; i < 12; ++i) {
    const double angle = 2.0 * M_PI * windings / 12.0 * i;
    values.insert(Key('x', i), SE2(std::sin(angle), -std::cos(angle), angle));
  }
  return values;
}

TEST(Staircase, LeavesTheMinimaOfOtherWindingNumbers) {
  PoseGraph graph;
  const Noise noise = Noise::isotropic(3, 0.3);
  for (int i = 0; i < 12; ++i) {
    graph.poses2.push_back({Key('x', i), Key('x', (i + 1) % 12), SE2(1, 0, M_PI / 6), noise});
  }
  for (const int windings : {0, 2, 3}) {
    const Climb climbed = climb_from(graph, wound(windings));
    EXPECT_GT(climbed.cost_before, 1.0) << windings;
    EXPECT_LT(climbed.stated_cost, 1e-9) << windings;
    EXPECT_TRUE(climbed.certificate.verified) << climbed.certificate.min_eigenvalue;
    EXPECT_GE(climbed.levels, 1);
  }
}

TEST(Staircase, AVerifiedEstimateStaysAsItIs) {
  const World world = worlds::torus(5, 8, {0.1, 0.05}, 3);
  const std::vector<ContinuousFactorPtr> factors = to_factors(world.graph, world.truth);
  SolverOptions options;
  options.relative_decrease = 1e-9;
  const Values best = levenberg_marquardt(HybridGraph(factors), {world.truth, {}}, options).values;
  const StaircaseResult climbed = climb_staircase(factors, best);
  EXPECT_TRUE(climbed.certificate.verified);
  EXPECT_EQ(climbed.levels, 0);
  EXPECT_EQ(climbed.cost, climbed.cost_before);
  for (const Key key : best.keys()) {
    EXPECT_TRUE(climbed.values.at<SE3>(key).translation() == best.at<SE3>(key).translation());
  }
}

TEST(Staircase, AFixedPoseStaysWhereItIs) {
  World world = worlds::town(60, 3, 0.4, {0.05, 0.05}, 7);
  world.graph.fixed = {Key('x', 31)};
  scramble(world, 7);
  world.graph.values.update(Key('x', 31), world.truth.at<SE2>(Key('x', 31)));
  const Climb climbed = climb_from(world.graph, world.graph.values);
  EXPECT_LT(climbed.stated_cost, 0.5 * climbed.cost_before);
  const SE2 moved = world.truth.at<SE2>(Key('x', 31)).between(climbed.values.at<SE2>(Key('x', 31)));
  EXPECT_LT(moved.log().norm(), 1e-6);
}

}  // namespace
}  // namespace hybrid
