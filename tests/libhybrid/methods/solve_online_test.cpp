// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/methods/solve_online.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "libhybrid/pose_graph/false_closures.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::pose;
using testing::random_motion;

/// Three laps on a circle; closures come before the odometry of the pose that they reach.
PoseGraph laps() {
  constexpr int kLap = 30;
  std::mt19937 rng(2);
  const SE2 step(1.0, 0.0, 2 * M_PI / kLap);
  const Noise noise = Noise::isotropic(3, 0.01);
  PoseGraph graph;
  std::vector<SE2> truth(1);
  for (int i = 1; i < 3 * kLap; ++i) {
    truth.push_back(truth.back() * step);
    if (i >= kLap) {
      const SE2 z = truth[i - kLap].between(truth[i]) * random_motion<SE2>(0.01, rng);
      graph.poses2.push_back({pose(i - kLap), pose(i), z, noise});
    }
    graph.poses2.push_back({pose(i - 1), pose(i), step * random_motion<SE2>(0.01, rng), noise});
  }
  return graph;
}

TEST(SolveOnline, VerdictsAreInTheOrderOfTheProblem) {
  const PoseGraph clean = laps();
  const PoseGraph graph = add_false_closures(clean, 0.5, 3);
  const Values initial = initialize_from_odometry(graph);
  const RobustProblem problem = to_robust_problem(graph, initial);
  const RobustResult result = solve_online(graph, initial);
  ASSERT_EQ(result.decisions.size(), problem.closures.size());
  ASSERT_EQ(result.decisions.size(), 120u);
  std::vector<bool> accepted;
  for (std::size_t k = 0; k < 120; ++k) {
    accepted.push_back(result.decisions[k].accepted());
    EXPECT_EQ(accepted.back(), k < 60) << k;
    EXPECT_EQ(result.decisions[k].inlier_probability > 0.5, k < 60) << k;
    EXPECT_NEAR(result.decisions[k].chi_square, 2.0 * problem.closures[k]->cost(result.values),
                0.1);
  }
  EXPECT_NEAR(joint_objective(problem, result.values, accepted).cost, result.cost, 1e-6);
}

TEST(SolveOnline, NamesAPoseThatNothingTrustedConnects) {
  PoseGraph graph = laps();
  const Values initial = initialize_from_odometry(graph);
  const auto untrusted = [](Key from, Key to) { return is_odometry(from, to) && to != pose(40); };
  try {
    solve_online(graph, initial, untrusted);
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("pose 40"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace hybrid
