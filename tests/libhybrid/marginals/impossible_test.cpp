// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/marginals/posterior.h"

namespace hybrid {
namespace {

/// A scalar with a prior, and a mode.
class PosteriorOfTheImpossible : public ::testing::TestWithParam<std::size_t> {
 protected:
  using Vector1 = Eigen::Matrix<double, 1, 1>;

  PosteriorOfTheImpossible() {
    options.max_assignments = GetParam();
    graph.add(prior);
    estimate.values.insert(x, Vector1(0.0));
    estimate.assignment.set(m.key, 0);
  }
  void add_mixture(double constant) {
    graph.add(HybridFactorPtr(std::make_shared<Mixture>(
        std::vector<DiscreteKey>{m},
        std::vector<MixtureComponent>{{prior, constant}, {prior, constant}})));
  }
  /// Expects an error from both ways to a posterior.
  void expect_impossible() const {
    for (const bool marginals : {false, true}) {
      try {
        marginals ? posterior_marginals(graph, estimate, {m.key}, options)
                  : posterior(graph, estimate, {m.key}, options);
        ADD_FAILURE() << "a posterior of what is impossible";
      } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).rfind("no joint value of m0", 0), 0U) << error.what();
      }
    }
  }

  const Key x{'x', 0};
  const DiscreteKey m{Key('m', 0), 2};
  const ContinuousFactorPtr prior =
      std::make_shared<Prior<Vector1>>(x, Vector1(0.0), Noise::isotropic(1, 1.0));
  HybridGraph graph;
  Estimate estimate;
  PosteriorOptions options;
};

TEST_P(PosteriorOfTheImpossible, OfNoVariablesIsEmpty) {
  EXPECT_TRUE(posterior(graph, estimate, {}, options).variables.empty());
  EXPECT_TRUE(posterior_marginals(graph, estimate, {}, options).variables.empty());
}

TEST_P(PosteriorOfTheImpossible, SaysItOfATable) {
  graph.add(Table({m}, {INFINITY, INFINITY}));
  expect_impossible();
}

TEST_P(PosteriorOfTheImpossible, SaysItOfTablesThatContradict) {
  graph.add(Table({m}, {0.0, INFINITY}));
  graph.add(Table({m}, {INFINITY, 0.0}));
  expect_impossible();
}

TEST_P(PosteriorOfTheImpossible, SaysItOfAMixture) {
  add_mixture(INFINITY);
  expect_impossible();
}

// One mode rules out all values of a variable that chooses nothing.
TEST_P(PosteriorOfTheImpossible, LeavesOutWhatTheRestRulesOut) {
  const DiscreteKey other{Key('c', 0), 2};
  add_mixture(0.0);
  graph.add(Table({m, other}, {INFINITY, INFINITY, 0.5, 0.5}));
  estimate.assignment.set(other.key, 0);
  const AssignmentPosterior found = posterior(graph, estimate, {m.key, other.key}, options);
  EXPECT_NEAR(found.at(m.key).p[1], 1.0, 1e-12);
  EXPECT_NEAR(found.at(other.key).p[0], 0.5, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(ByNumberEnumerated, PosteriorOfTheImpossible, ::testing::Values(64, 1, 0));

}  // namespace
}  // namespace hybrid
