// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/posterior.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/linear_motion.h"
#include "libhybrid/hybrid/semantic.h"
#include "libhybrid/hybrid/weighted.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/marginals/discrete.h"
#include "libhybrid/marginals/evidence.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/solvers/alternating.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/random.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::Random;
using Vector1 = Eigen::Matrix<double, 1, 1>;

DiscreteKey mode(int i) {
  return {Key('m', i), 2};
}

Key scalar(int i) {
  return {'x', static_cast<std::uint64_t>(i)};
}

ContinuousFactorPtr prior(int i, double z, double sigma) {
  return std::make_shared<Prior<Vector1>>(scalar(i), Vector1(z), Noise::isotropic(1, sigma));
}

ContinuousFactorPtr motion(int i, double z, double sigma) {
  return std::make_shared<LinearMotion<1>>(scalar(i), scalar(i + 1), Vector1(1.0), Vector1(z),
                                           Noise::isotropic(1, sigma));
}

HybridFactorPtr either(DiscreteKey key, ContinuousFactorPtr first, ContinuousFactorPtr second) {
  return std::make_shared<Mixture>(
      std::vector<DiscreteKey>{key},
      std::vector<MixtureComponent>{{std::move(first)}, {std::move(second)}});
}

Estimate solved(const HybridGraph& graph, const Estimate& start) {
  AlternatingOptions options;
  options.relative_decrease = 1e-14;
  options.continuous.relative_decrease = 1e-14;
  return alternate(graph, start, options).estimate;
}

/// Two scalars, of which a motion in one of two modes is known: the second mode's probability.
struct TwoStates {
  double mean[2], sigma[2];
  double prior_sigma, first, last;  // measured; last is NaN where it was not
  double second_mode;               // its probability, of a peer's published tests
  double tolerance = 0.002;         // theirs

  double density(int m) const {  // of the difference of what was measured
    const double variance = 18.0 + sigma[m] * sigma[m];
    return std::exp(-0.5 * std::pow(last - first - mean[m], 2) / variance) / std::sqrt(variance);
  }
};

// The values of GTSAM's tests of hybrid factors (DifferentCovariancesFG, TwoStateModel 1 to 4),
// which it has from exact elimination and from importance sampling.
TEST(Posterior, HasThePublishedNumbersOfAPeer) {
  const TwoStates cases[] = {{{0, 0}, {1e2, 1e-2}, 1e-3, 0.0, NAN, 0.5},
                             {{1, 3}, {0.5, 0.5}, 3, 0.5, 4.5, 0.556146},
                             {{1, 3}, {0.5, 2.0}, 3, 0.5, 4.0, 0.516842},
                             {{1, 3}, {0.5, 2.0}, 3, 0.5, 1.1, 0.44604},
                             {{1, 1}, {0.5, 2.0}, 3, 0.5, 4.0, 0.482238},
                             {{1, 1}, {0.5, 2.0}, 3, 0.5, 7.0, 0.509238, 0.005},
                             {{0, 10}, {0.2, 5.0}, 3, 0.0, 10.0, 0.910847}};
  for (const TwoStates& c : cases) {
    for (int start = 0; start < 2; ++start) {
      HybridGraph graph;
      graph.add(prior(0, c.first, c.prior_sigma));
      if (!std::isnan(c.last)) graph.add(prior(1, c.last, 3.0));
      graph.add(
          either(mode(0), motion(0, c.mean[0], c.sigma[0]), motion(0, c.mean[1], c.sigma[1])));
      graph.add(prior_table(mode(0), {0.5, 0.5}));
      Estimate estimate;
      estimate.values.insert(scalar(0), Vector1(0.0));
      estimate.values.insert(scalar(1), Vector1(1.0));
      estimate.assignment.set(mode(0).key, start);
      const AssignmentPosterior found = posterior(graph, solved(graph, estimate), {mode(0).key});
      EXPECT_TRUE(found.exact);
      EXPECT_NEAR(found.at(mode(0).key).p[1], c.second_mode, c.tolerance);
      const double exact = std::isnan(c.last) ? 0.5 : c.density(1) / (c.density(0) + c.density(1));
      EXPECT_NEAR(found.at(mode(0).key).p[1], exact, 1e-7);
      EXPECT_NEAR(found.joint[1], found.at(mode(0).key).p[1], 1e-15);
    }
  }
}

/// p(D | Z) of all selectors by solving the whole graph for every joint value.
std::vector<double> brute_force(const HybridGraph& graph, const Estimate& estimate,
                                const std::vector<DiscreteKey>& keys) {
  std::vector<double> weights;
  Estimate at = estimate;
  for (std::size_t n = 0; n < joint_size(keys); ++n) {
    std::size_t rest = n;
    for (auto key = keys.rbegin(); key != keys.rend(); ++key) {
      at.assignment.set(key->key, static_cast<int>(rest % key->cardinality));
      rest /= key->cardinality;
    }
    SolverOptions options;
    options.relative_decrease = 1e-14;
    at.values = levenberg_marquardt(graph, {estimate.values, at.assignment}, options).values;
    weights.push_back(*log_evidence(graph, at).log);
  }
  const double most = *std::max_element(weights.begin(), weights.end());
  double sum = 0.0;
  for (double& w : weights) sum += w = std::exp(w - most);
  for (double& w : weights) w /= sum;
  return weights;
}

/// A chain of scalars whose motions have modes with a Markov chain, some scalars measured; long
/// enough not to be solved whole.
struct Chain {
  HybridGraph graph;
  Estimate estimate;
  std::vector<Key> keys;

  Chain(int length, int modes, int seed, double sigma = 1.0) {
    Random random(seed);
    graph.add(prior(0, 0.0, 0.5));
    double truth = 0.0;
    estimate.values.insert(scalar(0), Vector1(0.0));
    for (int i = 0; i < length; ++i) {
      truth += random.normal(0.3);
      estimate.values.insert(scalar(i + 1), Vector1(truth));
      if (i < modes) {
        keys.push_back(mode(i).key);
        estimate.assignment.set(mode(i).key, 0);
        graph.add(either(mode(i), motion(i, 0.0, 0.3), motion(i, 0.4, 1.2)));
        if (i > 0) graph.add(transition_table(mode(i - 1), mode(i), {0.8, 0.2, 0.3, 0.7}));
        if (random.below(3) == 0) truth += random.normal(1.2);
      } else {
        graph.add(motion(i, 0.0, 0.3));
      }
      if (i % 2 == 1) graph.add(prior(i + 1, truth + random.normal(sigma), sigma));
    }
    estimate = solved(graph, estimate);
  }
};

JointCovariance of(const ContinuousMarginals& marginals) {
  return [&](const std::vector<Key>& keys) { return marginals.joint_covariance(keys); };
}

// The rest of a linear graph is the Gaussian that the local problem takes it for.
TEST(Posterior, EqualsSolvingTheWholeLinearGraphForEveryAssignment) {
  for (int seed = 1; seed <= 8; ++seed) {
    const Chain chain(40, 5, seed);
    const std::vector<double> expected =
        brute_force(chain.graph, chain.estimate, chain.graph.discrete_keys());
    const AssignmentPosterior found = posterior(chain.graph, chain.estimate, chain.keys);
    ASSERT_EQ(found.joint.size(), expected.size());
    for (std::size_t n = 0; n < expected.size(); ++n) {
      EXPECT_NEAR(found.joint[n], expected[n], 1e-8);
    }
  }
}

// A rank-deficient rest: nothing but the modes ties the chain together.
TEST(Posterior, BearsAChainThatOnlyItsModesHoldTogether) {
  const Chain chain(5, 5, 3, 100.0);
  HybridGraph longer = chain.graph;
  Estimate estimate = chain.estimate;
  for (int i = 100; i < 140; ++i) {  // too large to be solved whole
    estimate.values.insert(scalar(i), Vector1(0.0));
    longer.add(prior(i, 0.0, 1.0));
  }
  const std::vector<double> expected =
      brute_force(chain.graph, chain.estimate, chain.graph.discrete_keys());
  const AssignmentPosterior found = posterior(longer, estimate, chain.keys);
  for (std::size_t n = 0; n < expected.size(); ++n) {
    EXPECT_NEAR(found.joint[n], expected[n], 1e-8);
  }
}

TEST(Posterior, OfCurvedFactorsIsNearThatOfTheWholeGraph) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    testing::SimulatedGraph s = testing::simulate_loops<SE2, BetweenSE2>(14, 4, 0.05, seed);
    Random random(seed);
    std::vector<Key> keys;
    for (int k = 0; k < 3; ++k) {
      const Key a = testing::pose(k), b = testing::pose(9 + k);
      const SE2 z = s.truth.at<SE2>(a).between(s.truth.at<SE2>(b)) * random.value<SE2>(0.1);
      s.graph.add(either(mode(k), std::make_shared<BetweenSE2>(a, b, z, Noise::isotropic(3, 0.05)),
                         std::make_shared<BetweenSE2>(a, b, z, Noise::isotropic(3, 0.5))));
      s.initial.assignment.set(mode(k).key, 0);
      keys.push_back(mode(k).key);
    }
    const Estimate estimate = solved(s.graph, s.initial);
    const std::vector<double> expected = brute_force(s.graph, estimate, s.graph.discrete_keys());
    const AssignmentPosterior found = posterior(s.graph, estimate, keys);
    for (std::size_t n = 0; n < expected.size(); ++n) {
      EXPECT_NEAR(found.joint[n], expected[n], 0.03);
    }
  }
}

TEST(Posterior, IsTheSameFromTheBayesTree) {
  const Chain chain(40, 5, 7);
  IncrementalSmoother smoother;
  Delta delta;
  delta.values = chain.estimate.values;
  delta.assignment = chain.estimate.assignment;
  chain.graph.continuous().for_each([&](Handle, const auto& f) { delta.continuous.push_back(f); });
  chain.graph.discrete().for_each([&](Handle, const Table& t) { delta.discrete.push_back(t); });
  chain.graph.hybrid().for_each([&](Handle, const auto& f) { delta.hybrid.push_back(f); });
  smoother.update(delta);
  smoother.converge();
  ASSERT_EQ(smoother.assignment(), chain.estimate.assignment);
  const AssignmentPosterior online =
      posterior(smoother.graph(), smoother.estimate(), chain.keys,
                [&](const std::vector<Key>& keys) { return smoother.joint_covariance(keys); });
  const AssignmentPosterior batch = posterior(chain.graph, chain.estimate, chain.keys);
  for (std::size_t n = 0; n < batch.joint.size(); ++n) {
    EXPECT_NEAR(online.joint[n], batch.joint[n], 1e-8);
  }
}

TEST(Posterior, SampledIsWithinItsStandardErrorOfTheExact) {
  int within = 0, all = 0;
  for (int seed = 1; seed <= 12; ++seed) {
    const Chain chain(40, 10, seed);
    PosteriorOptions exact, sampled;
    exact.max_assignments = 1024;
    sampled.max_assignments = 1;
    sampled.seed = seed;
    const AssignmentPosterior a = posterior(chain.graph, chain.estimate, chain.keys, exact);
    const AssignmentPosterior b = posterior(chain.graph, chain.estimate, chain.keys, sampled);
    EXPECT_TRUE(a.exact);
    EXPECT_FALSE(b.exact);
    EXPECT_TRUE(b.joint.empty());
    for (Key key : chain.keys) {
      const double error = b.at(key).standard_error[1];
      EXPECT_LE(error, 0.01);
      const double off = std::abs(a.at(key).p[1] - b.at(key).p[1]);
      EXPECT_LT(off, 5.0 * error + 1e-4) << "seed " << seed << " " << key;
      within += off <= 2.0 * error + 1e-6;
      ++all;
    }
  }
  EXPECT_GT(within, 0.85 * all);
}

TEST(Posterior, SamplesTheSameForTheSameSeed) {
  const Chain chain(40, 10, 2);
  PosteriorOptions options;
  options.max_assignments = 1;
  const AssignmentPosterior a = posterior(chain.graph, chain.estimate, chain.keys, options);
  const AssignmentPosterior b = posterior(chain.graph, chain.estimate, chain.keys, options);
  options.seed = 2;
  const AssignmentPosterior c = posterior(chain.graph, chain.estimate, chain.keys, options);
  bool differs = false;
  for (Key key : chain.keys) {
    EXPECT_EQ(a.at(key).p, b.at(key).p);
    differs = differs || a.at(key).p != c.at(key).p;
  }
  EXPECT_TRUE(differs);
}

// Windows along a chain against all of it at once, each sampled.
TEST(PosteriorMarginals, OfALongChainAreNearThoseOfAllOfIt) {
  for (int seed = 1; seed <= 2; ++seed) {
    const Chain chain(60, 24, seed);
    const ContinuousMarginals marginals(chain.graph, chain.estimate);
    PosteriorOptions all;
    all.window = 80;
    const AssignmentPosterior a =
        posterior_marginals(chain.graph, chain.estimate, chain.keys, of(marginals));
    const AssignmentPosterior b =
        posterior_marginals(chain.graph, chain.estimate, chain.keys, of(marginals), all);
    EXPECT_FALSE(a.exact);
    ASSERT_EQ(a.variables.size(), chain.keys.size());
    for (Key key : chain.keys) {
      EXPECT_NEAR(a.at(key).p[1], b.at(key).p[1], 0.06) << key;
      EXPECT_NEAR(a.at(key).p[0] + a.at(key).p[1], 1.0, 1e-9);
    }
  }
}

// phi(D) psi(C): D weighs the factor and does not change it.
TEST(PosteriorMarginals, OfClassesAreTheConditionalOnes) {
  HybridGraph graph;
  Estimate estimate;
  const DiscreteKey species{Key('s', 0), 3};
  estimate.values.insert(Key('x', 0), SE2());
  estimate.values.insert(Key('l', 0), Eigen::Vector2d(3, 0.2));
  estimate.assignment.set(species.key, 1);
  graph.emplace<Prior<SE2>>(Key('x', 0), SE2(), Noise::isotropic(3, 0.1));
  for (int k = 0; k < 3; ++k) {
    graph.add(make_semantic_bearing_range<SE2>(
        Key('x', 0), Key('l', 0), species, Eigen::Vector2d(3.0 + 0.1 * k, 0.1),
        Noise::isotropic(2, 0.1), {0.5, 0.3 + 0.1 * k, 0.2}));
  }
  const AssignmentPosterior found = posterior_marginals(
      graph, estimate, {species.key}, [](const std::vector<Key>&) { return Eigen::MatrixXd(); });
  const DiscreteMarginals expected = discrete_marginals(graph, estimate.values);
  ASSERT_TRUE(found.exact);
  for (int s = 0; s < 3; ++s) {
    EXPECT_NEAR(found.at(species.key).p[s], expected.at(species.key)[s], 1e-12);
  }
}

// A class that a mode weighs: summed out for each mode, and itself known from all modes.
TEST(Posterior, SumsOutVariablesThatChooseNothing) {
  Chain chain(40, 3, 4);
  const DiscreteKey species{Key('s', 0), 2};
  HybridGraph with = chain.graph;
  with.add(Table({mode(1), species}, {0.1, 1.5, 2.0, 0.3}));
  with.add(Table({species}, {0.0, 0.4}));
  Estimate estimate = chain.estimate;
  estimate.assignment.set(species.key, 0);
  estimate = solved(with, estimate);
  const std::vector<DiscreteKey> keys = {mode(0), mode(1), mode(2), species};
  const std::vector<double> joint = brute_force(with, estimate, keys);
  double second = 0.0, class_1 = 0.0;
  for (std::size_t n = 0; n < joint.size(); ++n) {
    if ((n / 4) % 2 == 1) second += joint[n];
    if (n % 2 == 1) class_1 += joint[n];
  }
  const AssignmentPosterior found =
      posterior(with, estimate, {mode(0).key, mode(1).key, mode(2).key, species.key});
  EXPECT_TRUE(found.joint.empty());
  EXPECT_NEAR(found.at(mode(1).key).p[1], second, 1e-8);
  EXPECT_NEAR(found.at(species.key).p[1], class_1, 1e-8);
  PosteriorOptions sampled;
  sampled.max_assignments = 1;
  const AssignmentPosterior drawn =
      posterior(with, estimate, {mode(0).key, mode(1).key, mode(2).key, species.key}, sampled);
  EXPECT_NEAR(drawn.at(species.key).p[1], class_1, 0.05);
}

TEST(Posterior, GivesNoNumberWhereAValueLeavesVariablesUndetermined) {
  for (const int more : {0, 40}) {
    HybridGraph graph;
    Estimate estimate;
    estimate.values.insert(scalar(0), Vector1(0.0));
    estimate.values.insert(scalar(1), Vector1(1.0));
    graph.add(prior(0, 0.0, 1.0));
    graph.add(either(mode(0), motion(0, 1.0, 1.0), nullptr));
    for (int i = 2; i < 2 + more; ++i) {
      estimate.values.insert(scalar(i), Vector1(0.0));
      graph.add(prior(i, 0.0, 1.0));
    }
    estimate.assignment.set(mode(0).key, 0);
    for (const std::size_t enumerated : {64, 1}) {
      PosteriorOptions options;
      options.max_assignments = enumerated;
      const AssignmentPosterior found = posterior(graph, estimate, {mode(0).key}, options);
      EXPECT_TRUE(found.variables.empty());
      EXPECT_EQ(found.undetermined, std::vector<Key>{mode(0).key});
      EXPECT_NE(
          std::find(found.under_constrained.begin(), found.under_constrained.end(), scalar(1)),
          found.under_constrained.end());
    }
    // Where the prior rules the value out, what it would leave undetermined does not matter.
    graph.add(Table({mode(0)}, {0.0, INFINITY}));
    EXPECT_EQ(posterior(graph, estimate, {mode(0).key}).at(mode(0).key).p[0], 1.0);
  }
}

TEST(Posterior, RefusesAVariableInNoFactor) {
  const Chain chain(5, 2, 1);
  EXPECT_THROW(posterior(chain.graph, chain.estimate, {Key('z', 0)}), Error);
}

}  // namespace
}  // namespace hybrid
