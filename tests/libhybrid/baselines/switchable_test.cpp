// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/baselines/switchable.h"

#include <gtest/gtest.h>

#include "libhybrid/baselines/dcs.h"
#include "libhybrid/factors/expect_jacobians.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/corrupted_graph.h"

namespace hybrid {
namespace {

using Vector1 = Eigen::Matrix<double, 1, 1>;

TEST(Switchable, FactorIsTheResidualTimesTheSwitch) {
  const auto g = testing::drive_laps<SE2>(2, 1, 1);
  const ContinuousFactorPtr closure = g.problem.closures.back();
  const SwitchedFactor switched(closure, real_switch(0));
  Values values = g.problem.initial;
  values.insert(real_switch(0), Vector1(Vector1::Constant(0.3)));
  EXPECT_NEAR(switched.cost(values), 0.09 * closure->cost(values), 1e-9);
  testing::expect_jacobians(switched, values);
}

TEST(Switchable, SwitchesEndAtTheClosedForm) {
  const auto g = testing::drive_laps<SE2>(3, 6, 4);
  const double phi = 2.0;
  SwitchableOptions options;
  options.phi = phi;
  const RobustResult result = solve_switchable(g.problem, options);
  // Given the poses, the unknown switches alone are least squares with the answer known.
  for (const ContinuousFactorPtr& closure : g.problem.closures) {
    HybridGraph graph;
    graph.emplace<SwitchedFactor>(closure, real_switch(0));
    graph.emplace<Prior<Vector1>>(real_switch(0), Vector1::Ones(),
                                  Noise::isotropic(1, 1.0 / std::sqrt(phi)));
    Values values = result.values;
    values.insert(real_switch(0), Vector1(Vector1::Ones()));
    const double s = 2.0 * closure->cost(values);
    const double best = best_switch(s, phi);
    const auto cost = [&](double at) {
      values.update(real_switch(0), Vector1(Vector1::Constant(at)));
      return hybrid::cost(graph, values, {});
    };
    EXPECT_LE(cost(best), cost(best + 1e-3));
    EXPECT_LE(cost(best), cost(best - 1e-3));
    EXPECT_NEAR(cost(best), 0.5 * phi * s / (phi + s), 1e-9 * (1.0 + s));
    EXPECT_DOUBLE_EQ(dcs_scale(s, phi), std::min(1.0, 2.0 * best));
  }
}

TEST(Switchable, SolvedTogetherWithPosesEqualsTheKernelOfTheClosedForm) {
  const auto g = testing::drive_laps<SE2>(3, 4, 9);
  SwitchableOptions options;
  options.phi = 3.0;
  options.solver.relative_decrease = 1e-12;
  const RobustResult together = solve_switchable(g.problem, options);
  // With the best switch put in, a closure costs phi s / (phi + s): the Geman-McClure kernel.
  const double phi = options.phi;
  const Kernel eliminated{[phi](double s) { return phi * s / (phi + s); },
                          [phi](double s) {
                            const double t = phi / (phi + s);
                            return t * t;
                          }};
  RobustProblem started_there = g.problem;
  started_there.initial = together.values;
  const RobustResult again = solve_kernels(
      started_there, std::vector<Kernel>(g.problem.closures.size(), eliminated), 0.25, options);
  EXPECT_LT(testing::largest_error<SE2>(together.values, again.values), 1e-5);
}

TEST(Switchable, FindsTheLies) {
  const auto g = testing::drive_laps<SE2>(4, 15, 7);
  SwitchableOptions options;
  options.phi = 10.0;
  const RobustResult result = solve_switchable(g.problem, options);
  EXPECT_TRUE(result.converged) << result.message;
  for (std::size_t k = 0; k < g.truth.size(); ++k) {
    EXPECT_EQ(result.decisions[k].accepted(), g.truth[k]) << k;
  }
  EXPECT_LT(testing::largest_error<SE2>(result.values, g.poses), 0.05);
  EXPECT_FALSE(result.values.contains(real_switch(0)));
  options.phi = -1.0;
  EXPECT_THROW(solve_switchable(g.problem, options), Error);
}

}  // namespace
}  // namespace hybrid
