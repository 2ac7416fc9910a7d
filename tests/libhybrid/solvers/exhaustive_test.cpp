// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/exhaustive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/solvers/alternating.h"

namespace hybrid {
namespace {

using Scalar = Eigen::Matrix<double, 1, 1>;
using ScalarPrior = Prior<Scalar>;

const Key kX{'x', 0};
const double kHalfLog2Pi = 0.5 * std::log(2.0 * std::acos(-1.0));

Scalar scalar(double x) {
  return Scalar(x);
}

/// Exact for factors linear in x0: one Gauss-Newton step.
double linear_solver(const HybridGraph& graph, Estimate& estimate) {
  double h = 0.0, g = 0.0;
  const auto add = [&](const ContinuousFactor& factor) {
    const double* x[] = {estimate.values.data(kX)};
    double r = 0.0, J = 0.0;
    factor.linearize(x, &r, &J);
    h += J * J;
    g += J * r;
  };
  graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) { add(*factor); });
  graph.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    const Component component = factor->given(estimate.assignment);
    if (component.factor != nullptr) add(*component.factor);
  });
  estimate.values.update(kX, scalar(estimate.values.at<Scalar>(kX)[0] - g / h));
  return objective(graph, estimate.values, estimate.assignment);
}

/// A prior N(0, 1) on x0 and a mixture N(4, 1) with weight w0, N(10, 2^2) with weight 1 - w0.
HybridGraph two_modes(double w0) {
  HybridGraph graph;
  graph.emplace<ScalarPrior>(kX, scalar(0.0), Noise::isotropic(1, 1.0));
  graph.add(HybridFactorPtr(make_outlier_mixture(
      {Key('d', 0), 2}, std::make_shared<ScalarPrior>(kX, scalar(4.0), Noise::isotropic(1, 1.0)),
      std::make_shared<ScalarPrior>(kX, scalar(10.0), Noise::isotropic(1, 2.0)), w0, 1.0 - w0)));
  return graph;
}

TEST(Exhaustive, EqualsHandComputation) {
  Values values;
  values.insert(kX, scalar(-7.0));
  const ExhaustiveResult result = solve_exhaustive(two_modes(0.3), values, linear_solver);
  // Component 0: x = 2, cost 4/2 + 4/2. Component 1: x = 2, cost 4/2 + (8/2)^2/2.
  const double first = 2.0 + 2.0 + 2 * kHalfLog2Pi - std::log(0.3);
  const double second = 2.0 + 8.0 + 2 * kHalfLog2Pi + std::log(2.0) - std::log(0.7);
  ASSERT_EQ(result.objectives.size(), 2u);
  EXPECT_NEAR(result.objectives[0], first, 1e-12);
  EXPECT_NEAR(result.objectives[1], second, 1e-12);
  EXPECT_NEAR(result.objective, first, 1e-12);
  EXPECT_EQ(result.estimate.assignment.at(Key('d', 0)), 0);
  EXPECT_NEAR(result.estimate.values.at<Scalar>(kX)[0], 2.0, 1e-12);
}

TEST(Exhaustive, WeighsDiscreteFactors) {
  HybridGraph graph = two_modes(0.5);
  graph.add(transition_table({Key('d', 1), 3}, {Key('d', 0), 2}, {1, 0, 1, 0, 1e-9, 1 - 1e-9}));
  graph.add(prior_table({Key('d', 1), 3}, {0.0, 1e-12, 1.0}));
  Values values;
  values.insert(kX, scalar(1.0));
  const ExhaustiveResult result = solve_exhaustive(graph, values, linear_solver);
  EXPECT_EQ(result.objectives.size(), 6u);
  EXPECT_EQ(std::count_if(result.objectives.begin(), result.objectives.end(),
                          [](double o) { return std::isinf(o); }),
            3);
  EXPECT_EQ(result.estimate.assignment.at(Key('d', 1)), 2);
  EXPECT_EQ(result.estimate.assignment.at(Key('d', 0)), 1);
}

TEST(Exhaustive, SaysWhereNothingIsPossible) {
  HybridGraph graph = two_modes(0.5);
  const double infinity = std::numeric_limits<double>::infinity();
  graph.add(Table({{Key('d', 0), 2}}, {infinity, infinity}));
  Values values;
  values.insert(kX, scalar(1.0));
  EXPECT_EQ(solve_exhaustive(graph, values, linear_solver).objective, infinity);
}

TEST(Exhaustive, RefusesTooManyAssignments) {
  HybridGraph graph;
  for (int i = 0; i < 4; ++i) graph.add(prior_table({Key('d', i), 2}, {0.5, 0.5}));
  const ContinuousSolver none = [](const HybridGraph& g, Estimate& e) {
    return objective(g, e.values, e.assignment);
  };
  EXPECT_NEAR(solve_exhaustive(graph, {}, none, 16).objective, 4 * std::log(2.0), 1e-12);
  EXPECT_THROW(solve_exhaustive(graph, {}, none, 15), Error);
}

// Poses on a line, one step each, with three loop closures of which the second is false.
TEST(Exhaustive, FindsTheFalseLoopOfAPoseGraph) {
  HybridGraph graph;
  Values values;
  const Noise noise = Noise::isotropic(3, 0.05);
  const auto x = [](int i) { return Key('x', static_cast<std::uint64_t>(i)); };
  graph.emplace<Prior<SE2>>(x(0), SE2(), noise);
  for (int i = 0; i < 6; ++i) {
    values.insert(x(i), SE2(1.1 * i, 0.1, 0.05 * i));
    if (i > 0) graph.emplace<BetweenSE2>(x(i - 1), x(i), SE2(1.0, 0.0, 0.0), noise);
  }
  const auto loop = [&](int d, int i, int j, const SE2& measured) {
    graph.add(make_outlier_mixture(
        {Key('d', d), 2}, std::make_shared<BetweenSE2>(x(i), x(j), measured, noise),
        std::make_shared<BetweenSE2>(x(i), x(j), measured, noise.inflated(1e4)), 0.5, 0.5));
  };
  loop(0, 0, 3, SE2(3.02, 0.01, 0.0));
  loop(1, 0, 5, SE2(-2.0, 1.0, 1.0));
  loop(2, 1, 5, SE2(4.0, -0.02, 0.01));
  const ExhaustiveResult best = solve_exhaustive(graph, values);
  EXPECT_EQ(best.objectives.size(), 8u);
  EXPECT_EQ(best.estimate.assignment.at(Key('d', 0)), 0);
  EXPECT_EQ(best.estimate.assignment.at(Key('d', 1)), 1);
  EXPECT_EQ(best.estimate.assignment.at(Key('d', 2)), 0);
  EXPECT_NEAR(best.estimate.values.at<SE2>(x(5)).x(), 5.0, 0.05);
  const AlternatingResult alternated = alternate(graph, best.estimate);
  EXPECT_TRUE(alternated.estimate.assignment == best.estimate.assignment);
  EXPECT_NEAR(alternated.report.objective, best.objective, 1e-6);
}

}  // namespace
}  // namespace hybrid
