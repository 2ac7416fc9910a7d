// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/baselines/dcs.h"
#include "libhybrid/baselines/least_squares.h"
#include "libhybrid/baselines/max_mixture.h"
#include "libhybrid/factors/expect_jacobians.h"
#include "tests/support/corrupted_graph.h"

namespace hybrid {
namespace {

void expect_weight_is_slope(const Kernel& kernel, std::initializer_list<double> points) {
  EXPECT_DOUBLE_EQ(kernel.value(0.0), 0.0);
  for (double s : points) {
    const double h = 1e-6 * s;
    EXPECT_NEAR(kernel.weight(s), (kernel.value(s + h) - kernel.value(s - h)) / (2.0 * h), 1e-6)
        << s;
  }
}

TEST(Dcs, ScaleOfThePaper) {
  EXPECT_DOUBLE_EQ(dcs_scale(0.5, 1.0), 1.0);
  EXPECT_DOUBLE_EQ(dcs_scale(1.0, 1.0), 1.0);
  EXPECT_DOUBLE_EQ(dcs_scale(3.0, 1.0), 0.5);
  EXPECT_DOUBLE_EQ(dcs_scale(35.0, 5.0), 0.25);
}

TEST(Dcs, WeightIsTheSquaredScaleAndTheSlope) {
  const Kernel kernel = dcs_kernel(2.0);
  for (double s : {0.1, 2.5, 80.0}) {
    EXPECT_DOUBLE_EQ(kernel.weight(s), dcs_scale(s, 2.0) * dcs_scale(s, 2.0));
  }
  expect_weight_is_slope(kernel, {0.1, 1.9, 2.1, 30.0, 1e4});
}

TEST(MaxMixture, IsTheLikelierComponent) {
  const auto g = testing::drive_laps<SE2>(2, 3, 1);
  MixtureOptions mixture;
  mixture.outlier_weight = 0.2;
  const ContinuousFactor& closure = *g.problem.closures.back();
  const Kernel kernel = max_mixture_kernel(closure, mixture);
  const std::vector<ContinuousFactorPtr> one = {g.problem.closures.back()};
  const RobustProblem problem{{}, one, g.problem.initial};
  const double inlier = joint_objective(problem, g.problem.initial, {true}, mixture).objective;
  const double outlier = joint_objective(problem, g.problem.initial, {false}, mixture).objective;
  const double s = 2.0 * closure.cost(g.problem.initial);
  const double constant = closure.log_normalizer() - std::log(mixture.inlier_weight);
  EXPECT_NEAR(0.5 * kernel.value(s) + constant, std::min(inlier, outlier), 1e-9);
  EXPECT_EQ(kernel.weight(s), inlier < outlier ? 1.0 : 1e-7);
  expect_weight_is_slope(kernel, {1.0, 20.0, 1e3});
}

TEST(MaxMixture, ConstantNullHypothesis) {
  const auto g = testing::drive_laps<SE2>(2, 0, 1);
  MixtureOptions mixture;
  mixture.null_hypothesis = g.problem.closures[0]->log_normalizer() + 10.0;
  const Kernel kernel = max_mixture_kernel(*g.problem.closures[0], mixture);
  EXPECT_DOUBLE_EQ(kernel.value(19.9), 19.9);
  EXPECT_NEAR(kernel.value(1e6), 20.0, 1e-9);
  EXPECT_EQ(kernel.weight(1e6), 0.0);
}

TEST(MaxMixture, FlatOutlierModel) {
  const auto g = testing::drive_laps<SE2>(2, 3, 1);
  MixtureOptions mixture;
  mixture.flat = true;
  mixture.outlier_weight = 0.2;
  const ContinuousFactor& closure = *g.problem.closures.back();
  const Kernel kernel = max_mixture_kernel(closure, mixture);
  const RobustProblem problem{{}, {g.problem.closures.back()}, g.problem.initial};
  const double outlier = joint_objective(problem, g.problem.initial, {false}, mixture).objective;
  const double constant = closure.log_normalizer() - std::log(mixture.inlier_weight);
  EXPECT_NEAR(0.5 * kernel.value(1e9) + constant, outlier, 1e-9);
  EXPECT_EQ(kernel.weight(1e9), 0.0);
}

TEST(KernelFactor, ScalesResidualAndJacobian) {
  const auto g = testing::drive_laps<SE2>(2, 1, 1);
  const KernelFactor plain(g.problem.closures.back(),
                           {[](double s) { return 0.25 * s; }, [](double) { return 0.25; }});
  testing::expect_jacobians(plain, g.problem.initial);
  EXPECT_THROW(KernelFactor(nullptr, dcs_kernel(1.0)), Error);
}

template <class Solve>
void expect_recovery(const Solve& solve, int lies, double tolerance) {
  const auto g = testing::drive_laps<SE2>(4, lies, 7);
  const RobustResult result = solve(g.problem);
  EXPECT_TRUE(result.converged) << result.message;
  for (std::size_t k = 0; k < g.truth.size(); ++k) {
    EXPECT_EQ(result.decisions[k].accepted(), g.truth[k]) << result.method << " " << k;
  }
  EXPECT_LT(testing::largest_error<SE2>(result.values, g.poses), tolerance) << result.method;
  EXPECT_GT(result.iterations, 0);
}

TEST(Kernels, FindTheLies) {
  DcsOptions dcs;
  dcs.phi = 5.0;
  expect_recovery([&](const RobustProblem& p) { return solve_dcs(p, dcs); }, 15, 0.05);
  expect_recovery([](const RobustProblem& p) { return solve_max_mixture(p); }, 15, 0.05);
}

TEST(Plain, BelievesWhatItIsTold) {
  const auto g = testing::drive_laps<SE2>(3, 10, 3);
  const RobustResult lied_to = solve_lm(g.problem);
  EXPECT_GT(testing::largest_error<SE2>(lied_to.values, g.poses), 0.3);
  for (const ClosureDecision& decision : lied_to.decisions) EXPECT_TRUE(decision.accepted());
  const RobustResult told = solve_given(g.problem, g.truth);
  EXPECT_LT(testing::largest_error<SE2>(told.values, g.poses), 0.05);
  EXPECT_LT(told.objective, lied_to.objective);
  EXPECT_THROW(solve_given(g.problem, {true}), Error);
}

TEST(Dcs, RefusesAPhiThatIsNotPositive) {
  const auto g = testing::drive_laps<SE2>(2, 1, 3);
  DcsOptions options;
  options.phi = 0.0;
  EXPECT_THROW(solve_dcs(g.problem, options), Error);
}

}  // namespace
}  // namespace hybrid
