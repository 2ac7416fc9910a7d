// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/hybrid/graph.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"

namespace hybrid {
namespace {

const Key kX0{'x', 0};
const Key kX1{'x', 1};
const DiscreteKey kD{Key('d', 0), 2};
const double kLog2Pi = std::log(2.0 * std::acos(-1.0));

struct Example {
  HybridGraph graph;
  Handle prior, table, mixture;
  Values values;
  Assignment assignment;
};

/// x0 at the origin, x1 one metre ahead; a motion of 1.2 m measured with sigma 0.1 (inlier), or 1
/// (outlier); the assignment says inlier.
Example make_example() {
  Example e;
  e.prior = e.graph.emplace<Prior<SE2>>(kX0, SE2(), Noise::unit(3));
  e.table = e.graph.add(prior_table(kD, {0.75, 0.25}));
  const Noise noise = Noise::isotropic(3, 0.1);
  const SE2 measured(1.2, 0.0, 0.0);
  e.mixture = e.graph.add(make_outlier_mixture(
      kD, std::make_shared<BetweenSE2>(kX0, kX1, measured, noise),
      std::make_shared<BetweenSE2>(kX0, kX1, measured, noise.inflated(100.0)), 1.0, 1.0));
  e.values.insert(kX0, SE2());
  e.values.insert(kX1, SE2(1.0, 0.0, 0.0));
  e.assignment.set(kD.key, 0);
  return e;
}

TEST(HybridGraph, ObjectiveEqualsHandComputation) {
  Example e = make_example();
  const double gaussian = 1.5 * kLog2Pi;
  const double inlier = gaussian + gaussian + 3 * std::log(0.1) + 2.0 - std::log(0.75);
  EXPECT_NEAR(objective(e.graph, e.values, e.assignment), inlier, 1e-12);
  EXPECT_NEAR(cost(e.graph, e.values, e.assignment), 2.0, 1e-12);
  e.assignment.set(kD.key, 1);
  const double outlier = gaussian + gaussian + 0.02 - std::log(0.25);
  EXPECT_NEAR(objective(e.graph, e.values, e.assignment), outlier, 1e-12);
  EXPECT_NEAR(cost(e.graph, e.values, e.assignment), 0.02, 1e-12);
}

TEST(HybridGraph, GrowsAndShrinksByHandle) {
  Example e = make_example();
  EXPECT_EQ(e.graph.size(), 3u);
  const double before = objective(e.graph, e.values, e.assignment);
  e.graph.remove(e.table);
  EXPECT_FALSE(e.graph.contains(e.table));
  EXPECT_NEAR(objective(e.graph, e.values, e.assignment), before + std::log(0.75), 1e-12);
  EXPECT_THROW(e.graph.remove(e.table), Error);
  e.graph.remove(e.mixture);
  e.graph.remove(e.prior);
  EXPECT_EQ(e.graph.size(), 0u);
  EXPECT_EQ(objective(e.graph, e.values, e.assignment), 0.0);
  const Handle again = e.graph.add(prior_table(kD, {0.5, 0.5}));
  EXPECT_FALSE(e.graph.contains(e.table));
  EXPECT_TRUE(e.graph.contains(again));
}

TEST(HybridGraph, ListsDiscreteVariablesOnce) {
  Example e = make_example();
  EXPECT_EQ(e.graph.discrete_keys(), std::vector<DiscreteKey>{kD});
  e.graph.add(prior_table({kD.key, 3}, {1, 1, 1}));
  EXPECT_THROW(e.graph.discrete_keys(), Error);
}

TEST(HybridGraph, RefusesNullFactorsAndMissingValues) {
  Example e = make_example();
  EXPECT_THROW(e.graph.add(ContinuousFactorPtr()), Error);
  EXPECT_THROW(e.graph.add(HybridFactorPtr()), Error);
  e.values.erase(kX1);
  EXPECT_THROW(objective(e.graph, e.values, e.assignment), Error);
  Example f = make_example();
  f.assignment.erase(kD.key);
  EXPECT_THROW(objective(f.graph, f.values, f.assignment), Error);
}

}  // namespace
}  // namespace hybrid
