// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/starts.h"

#include <gtest/gtest.h>

#include <limits>

#include "libhybrid/core/error.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/pose_graph_worlds.h"

namespace hybrid {
namespace {

using worlds::World;

SolverOptions exact_solver() {
  SolverOptions options;
  options.relative_decrease = 1e-9;
  return options;
}

StartsResult solve(const PoseGraph& graph, const std::string& name, const Values& initial,
                   const SolverOptions& options = exact_solver()) {
  const std::vector<ContinuousFactorPtr> factors = to_factors(graph, initial);
  return solve_from_starts(HybridGraph(factors), pose_graph_starts(graph, factors, name, initial),
                           options);
}

/// Of Levenberg-Marquardt alone.
double cost_from(const PoseGraph& graph, const Values& initial, int iterations = 300) {
  SolverOptions options = exact_solver();
  options.max_iterations = iterations;
  return levenberg_marquardt(HybridGraph(to_factors(graph, initial)), {initial, {}}, options)
      .report.final_cost();
}

struct Case {
  const char* name;
  World (*make)(unsigned seed);
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << c.name;
}

class Worlds : public ::testing::TestWithParam<Case> {};

TEST_P(Worlds, EndInThePlantedOptimumWhateverTheFileHolds) {
  for (unsigned seed = 11; seed < 14; ++seed) {
    World world = GetParam().make(seed);
    const double planted = cost_from(world.graph, world.truth);
    const Values odometry = initialize_from_odometry(world.graph);
    EXPECT_LT(solve(world.graph, "odometry", odometry).report.final_cost(), planted * (1 + 1e-6));
    scramble(world, seed);
    const StartsResult scrambled = solve(world.graph, "file", world.graph.values);
    EXPECT_LT(scrambled.report.final_cost(), planted * (1 + 1e-6));
    EXPECT_NE(scrambled.trials[scrambled.won].name, "file");
    EXPECT_EQ(scrambled.trials.size(), 4u);
    EXPECT_GT(cost_from(world.graph, world.graph.values, 30), 2 * planted);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Made, Worlds,
    ::testing::Values(Case{"sphere",
                           [](unsigned s) {
                             return worlds::sphere(10, 30, {0.1, 0.3}, s);
                           }},
                      Case{"torus",
                           [](unsigned s) {
                             return worlds::torus(12, 20, {0.1, 0.2}, s);
                           }},
                      Case{"grid",
                           [](unsigned s) {
                             return worlds::grid3(6, 0.7, {0.1, 0.2}, s);
                           }},
                      Case{"town",
                           [](unsigned s) {
                             return worlds::town(500, 6, 0.3, {0.05, 0.08}, s);
                           }},
                      Case{"building",
                           [](unsigned s) {
                             return worlds::building(4, 40, {0.1, 0.1}, {0.05, 0.02}, s);
                           }}),
    [](const auto& info) { return info.param.name; });

TEST(Starts, TheFirstOneAloneEndsHigher) {
  const World world = worlds::torus(25, 30, {0.1, 0.3}, 1);
  const double planted = cost_from(world.graph, world.truth);
  const Values odometry = initialize_from_odometry(world.graph);
  EXPECT_GT(cost_from(world.graph, odometry, 60), 2 * planted);
  EXPECT_NEAR(solve(world.graph, "odometry", odometry).report.final_cost(), planted,
              1e-6 * planted);
}

TEST(Starts, NoOtherIsTriedWhereNoiseExplainsTheFirst) {
  const World world = worlds::town(400, 6, 0.3, {0.05, 0.02}, 3);
  const Values odometry = initialize_from_odometry(world.graph);
  std::vector<ContinuousFactorPtr> factors = to_factors(world.graph, odometry);
  const HybridGraph graph(factors);
  const auto never = []() -> Values { throw Error("this start was wanted"); };
  const StartsResult result = solve_from_starts(
      graph, {{"odometry", [&] { return odometry; }}, {"other", never}}, exact_solver());
  EXPECT_EQ(result.trials.size(), 1u);
  EXPECT_EQ(result.report.status, SolverStatus::kConverged);
  const double alone = cost_from(world.graph, odometry);
  EXPECT_NEAR(result.report.final_cost(), alone, 1e-9 * alone);
}

TEST(Starts, NoiseExplainsTheTruthAndNoGrossError) {
  World world = worlds::torus(12, 20, {0.1, 0.05}, 5);
  const auto explained = [&] {
    const HybridGraph graph(to_factors(world.graph, world.truth));
    Problem problem(graph, world.truth, {});
    Problem::State state = problem.load(world.truth);
    levenberg_marquardt(problem, state);
    return is_explained_by_noise(problem, state);
  };
  EXPECT_TRUE(explained());
  const PoseGraph good = world.graph;
  // One gross error, which the sum over all would hide where the noise of the others is overstated.
  for (auto& edge : world.graph.poses3) edge.noise = edge.noise.inflated(25.0);
  EXPECT_TRUE(explained());
  auto& bad = world.graph.poses3.back();
  bad.measured = bad.measured * SE3({15.0, 0.0, 0.0}, SO3());
  EXPECT_FALSE(explained());
  // All a little too large.
  world.graph = good;
  for (auto& edge : world.graph.poses3) edge.noise = edge.noise.inflated(1 / 1.3);
  EXPECT_FALSE(explained());
}

TEST(Starts, OneThatIsNoNumberLoses) {
  World world = worlds::torus(6, 12, {0.1, 0.05}, 5);
  Values far = initialize_from_odometry(world.graph);
  for (const Key key : far.keys()) {
    if (key.index() == 40) far.update(key, SE3({1e300, 0.0, 0.0}, SO3()));
  }
  const StartsResult result = solve(world.graph, "file", far);
  EXPECT_EQ(result.trials.size(), 4u);
  EXPECT_NE(result.trials[result.won].name, "file");
  EXPECT_NEAR(result.report.final_cost(), cost_from(world.graph, world.truth), 1e-3);
}

TEST(Starts, TheLimitOfIterationsHolds) {
  const World world = worlds::sphere(8, 20, {0.1, 0.3}, 2);
  const Values odometry = initialize_from_odometry(world.graph);
  for (const int limit : {1, 3, 7}) {
    SolverOptions options = exact_solver();
    options.max_iterations = limit;
    const StartsResult result = solve(world.graph, "odometry", odometry, options);
    EXPECT_EQ(result.report.status, SolverStatus::kIterationLimit);
    for (const StartTrial& trial : result.trials) EXPECT_LE(trial.iterations, limit);
  }
  EXPECT_THROW(solve_from_starts({}, {}), Error);
}

TEST(Starts, ManyThreadsFindTheSame) {
  const World world = worlds::grid3(6, 0.7, {0.1, 0.2}, 4);
  const Values odometry = initialize_from_odometry(world.graph);
  SolverOptions one = exact_solver(), four = exact_solver();
  one.threads = 1;
  four.threads = 4;
  const StartsResult a = solve(world.graph, "odometry", odometry, one);
  const StartsResult b = solve(world.graph, "odometry", odometry, four);
  EXPECT_EQ(a.report.costs, b.report.costs);
  EXPECT_EQ(a.won, b.won);
}

TEST(Tree, FollowsExactMeasurements) {
  const World world = worlds::grid3(5, 0.6, {1e-9, 1e-9}, 3);
  const Values tree = initialize_from_tree(world.graph);
  const SE3 T = world.truth.at<SE3>(Key('x', 0));
  ASSERT_EQ(tree.size(), world.truth.size());
  for (const Key key : world.truth.keys()) {
    const SE3 expected = T.between(world.truth.at<SE3>(key));
    EXPECT_LT(expected.between(tree.at<SE3>(key)).log().norm(), 1e-6) << to_string(key);
  }
}

TEST(Tree, TakesTheWayOfLeastVarianceOfRotation) {
  PoseGraph graph;
  const auto edge = [&](int a, int b, double x, double rotation) {
    graph.poses2.push_back({Key('x', a), Key('x', b), SE2(x, 0, 0),
                            Noise::diagonal(Eigen::Vector3d(0.1, 0.1, rotation))});
  };
  edge(0, 1, 1.0, 0.1);  // 0.01 rad^2 each
  edge(1, 2, 1.0, 0.1);
  edge(0, 2, 7.0, 0.15);  // 0.0225 rad^2: longer than both
  edge(3, 0, 5.0, 0.1);   // backwards
  edge(2, 3, 1.0, 0.1);
  graph.points2.push_back(
      {Key('x', 2), Key('l', 0), Eigen::Vector2d(1, 1), Noise::isotropic(2, 0.1)});
  const Values tree = initialize_from_tree(graph);
  EXPECT_NEAR(tree.at<SE2>(Key('x', 2)).x(), 2.0, 1e-12);
  EXPECT_NEAR(tree.at<SE2>(Key('x', 3)).x(), -5.0, 1e-12);
  EXPECT_NEAR(tree.at<Eigen::Vector2d>(Key('l', 0)).x(), 3.0, 1e-12);
  graph.poses2[2].noise = Noise::diagonal(Eigen::Vector3d(0.1, 0.1, 0.13));  // 0.0169: shorter
  EXPECT_NEAR(initialize_from_tree(graph).at<SE2>(Key('x', 2)).x(), 7.0, 1e-12);
  graph.poses2.push_back({Key('x', 8), Key('x', 9), SE2(), Noise::isotropic(3, 0.1)});
  EXPECT_THROW(initialize_from_tree(graph), Error);
}

}  // namespace
}  // namespace hybrid
