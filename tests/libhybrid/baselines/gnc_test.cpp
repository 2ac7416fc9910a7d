// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/baselines/gnc.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/baselines/least_squares.h"
#include "tests/support/corrupted_graph.h"

namespace hybrid {
namespace {

/// The surrogate of eq. 8 of the paper with its best weight put in, rho_mu(s).
double surrogate(double s, double mu, double c2) {
  if (s <= mu / (mu + 1.0) * c2) return s;
  if (s >= (mu + 1.0) / mu * c2) return c2;
  return 2.0 * std::sqrt(c2 * s * mu * (mu + 1.0)) - mu * (c2 + s);
}

TEST(Gnc, WeightOfTruncatedLeastSquaresIsTheSlopeOfItsSurrogate) {
  const double c2 = 11.3;
  for (double mu : {1e-4, 0.1, 1.0, 30.0}) {
    for (double s : {0.3, 5.0, 9.0, 11.0, 14.0, 40.0, 5000.0}) {
      const double h = 1e-6 * s;
      const double slope = (surrogate(s + h, mu, c2) - surrogate(s - h, mu, c2)) / (2.0 * h);
      EXPECT_NEAR(gnc_weight(GncLoss::kTruncatedLeastSquares, s, mu, c2), slope, 1e-6)
          << mu << " " << s;
    }
  }
}

TEST(Gnc, WeightOfGemanMcClureIsTheSlopeOfItsSurrogate) {
  const double c2 = 2.5;
  for (double mu : {1.0, 10.0, 1e4}) {
    for (double s : {0.1, 2.0, 300.0}) {
      const auto rho = [&](double x) { return mu * c2 * x / (mu * c2 + x); };
      const double h = 1e-5 * s;
      EXPECT_NEAR(gnc_weight(GncLoss::kGemanMcClure, s, mu, c2),
                  (rho(s + h) - rho(s - h)) / (2 * h), 1e-7);
    }
  }
}

TEST(Gnc, FirstMuMakesTheSurrogateConvexAtTheWorstResidual) {
  const double c2 = 11.3;
  const double worst = 1e5;
  const double mu = gnc_first_mu(GncLoss::kTruncatedLeastSquares, worst, c2);
  EXPECT_DOUBLE_EQ(mu, c2 / (2.0 * worst - c2));
  EXPECT_GT(gnc_weight(GncLoss::kTruncatedLeastSquares, worst, mu, c2), 0.0);
  EXPECT_DOUBLE_EQ(gnc_first_mu(GncLoss::kGemanMcClure, worst, c2), 2.0 * worst / c2);
  EXPECT_LT(gnc_first_mu(GncLoss::kTruncatedLeastSquares, 3.0, c2), 0.0);
  EXPECT_DOUBLE_EQ(gnc_next_mu(GncLoss::kTruncatedLeastSquares, mu, 1.4), 1.4 * mu);
  EXPECT_DOUBLE_EQ(gnc_next_mu(GncLoss::kGemanMcClure, 14.0, 1.4), 10.0);
  EXPECT_DOUBLE_EQ(gnc_next_mu(GncLoss::kGemanMcClure, 1.2, 1.4), 1.0);
}

template <class Group>
void expect_recovery(GncLoss loss, int lies) {
  const auto g = testing::drive_laps<Group>(4, lies, 5);
  GncOptions options;
  options.loss = loss;
  const RobustResult result = solve_gnc(g.problem, options);
  EXPECT_TRUE(result.converged) << result.message;
  for (std::size_t k = 0; k < g.truth.size(); ++k) {
    EXPECT_EQ(result.decisions[k].accepted(), g.truth[k]) << k;
  }
  const RobustResult told = solve_given(g.problem, g.truth);
  EXPECT_LT(testing::largest_error<Group>(result.values, told.values), 5e-3);
}

TEST(Gnc, FindsTheLies) {
  expect_recovery<SE2>(GncLoss::kTruncatedLeastSquares, 40);
  expect_recovery<SE2>(GncLoss::kGemanMcClure, 20);
  expect_recovery<SE3>(GncLoss::kTruncatedLeastSquares, 40);
}

TEST(Gnc, WithoutLiesIsLeastSquares) {
  const auto g = testing::drive_laps<SE2>(3, 0, 2);
  GncOptions options;
  options.inlier_probability = 0.999999;
  const RobustResult result = solve_gnc(g.problem, options);
  EXPECT_TRUE(result.converged);
  for (const ClosureDecision& decision : result.decisions) EXPECT_TRUE(decision.accepted());
}

TEST(Gnc, BadOptionsAndNoClosures) {
  auto g = testing::drive_laps<SE2>(2, 1, 2);
  GncOptions options;
  options.inlier_probability = 1.0;
  EXPECT_THROW(solve_gnc(g.problem, options), Error);
  options = {};
  options.growth = 1.0;
  EXPECT_THROW(solve_gnc(g.problem, options), Error);
  g.problem.closures.clear();
  const RobustResult result = solve_gnc(g.problem);
  EXPECT_TRUE(result.decisions.empty());
  EXPECT_TRUE(result.converged);
}

}  // namespace
}  // namespace hybrid
