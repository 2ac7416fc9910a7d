// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/dogleg.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::pose;

SolverOptions tight() {
  SolverOptions options;
  options.relative_decrease = 1e-12;
  return options;
}

TEST(Dogleg, MeetsLevenbergMarquardt) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const auto s = testing::simulate_loops<SE2, BetweenSE2>(50, 30, 0.03, seed);
    const SolverResult a = dogleg(s.graph, s.initial, tight());
    const SolverResult b = levenberg_marquardt(s.graph, s.initial, tight());
    EXPECT_EQ(a.report.status, SolverStatus::kConverged) << a.report.message;
    EXPECT_NEAR(a.report.final_cost(), b.report.final_cost(), 1e-8 * b.report.final_cost());
    EXPECT_LT(testing::distance(a.values, b.values), 1e-4);
  }
}

TEST(Dogleg, NeverRaisesTheCostFromAFarStartWithASmallRegion) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    auto s = testing::simulate_loops<SE3>(40, 60, 0.05, seed);
    std::mt19937 rng(seed);
    for (int i = 1; i < 40; ++i)
      s.initial.values.update(pose(i), testing::random_motion<SE3>(3.0, rng));
    SolverOptions options;
    options.initial_radius = 0.1;
    const SolverResult result = dogleg(s.graph, s.initial, options);
    EXPECT_TRUE(std::is_sorted(result.report.costs.rbegin(), result.report.costs.rend()));
    EXPECT_LT(result.report.final_cost(), 0.1 * result.report.costs.front());
  }
}

TEST(Dogleg, NamesAllPosesOfAGraphWithoutPrior) {
  auto s = testing::simulate_loops<SE2>(30, 20, 0.05, 7);
  s.graph.remove(s.graph.continuous().handle(0));
  const SolverResult result = dogleg(s.graph, s.initial);
  EXPECT_EQ(result.report.status, SolverStatus::kUnderConstrained);
  EXPECT_EQ(result.report.under_constrained.size(), 30u);
  EXPECT_LT(result.report.final_cost(), 0.5 * result.report.costs.front());
}

}  // namespace
}  // namespace hybrid
