// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/hybrid/soft_mixture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/expect_jacobians.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/weighted.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/solvers/alternating.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::linearization;
using testing::numeric_derivative;
using testing::Random;

const Key kA{'x', 0}, kB{'x', 1}, kC{'x', 2};

/// Two measurements of different pairs of poses, of different noise, and a null hypothesis.
std::vector<MixtureComponent> three_components(Random& random) {
  return {{std::make_shared<Between<SE2>>(kA, kB, random.value<SE2>(), random.noise(3)), 0.7},
          {std::make_shared<Between<SE2>>(kA, kC, random.value<SE2>(), random.noise(3, 3.0)), 1.2},
          {nullptr, 6.0}};
}

Values three_poses(Random& random) {
  Values values;
  for (Key key : {kA, kB, kC}) values.insert(key, random.value<SE2>());
  return values;
}

/// -log of each component.
std::vector<double> component_costs(const std::vector<MixtureComponent>& components,
                                    const Values& values) {
  std::vector<double> out;
  for (const MixtureComponent& c : components) {
    out.push_back(c.constant +
                  (c.factor ? c.factor->cost(values) + c.factor->log_normalizer() : 0.0));
  }
  return out;
}

TEST(SoftMixture, IsTheSumOfItsComponents) {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    const auto components = three_components(random);
    const Values values = three_poses(random);
    const SoftMixture soft(components);
    double sum = 0.0;
    for (double c : component_costs(components, values)) sum += std::exp(-c);
    EXPECT_NEAR(soft.cost(values) + soft.log_normalizer(), -std::log(sum), 1e-9);
    EXPECT_GE(soft.cost(values), 0.0);
    EXPECT_NEAR(soft.weights(values).sum(), 1.0, 1e-12);
  }
}

TEST(SoftMixture, GradientIsExactAndResidualsHoldTheCost) {
  Random random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const SoftMixture soft(three_components(random), trial % 2 == 0 ? 1.0 : 0.3);
    const Values values = three_poses(random);
    const auto l = linearization(soft, values);
    EXPECT_NEAR(l.cost, soft.cost(values), 1e-12);
    EXPECT_NEAR(0.5 * l.r.squaredNorm(), l.cost, 1e-9 * (1.0 + l.cost));
    const Eigen::MatrixXd numeric = numeric_derivative(soft, values, [&](const double* const* x) {
      return Eigen::VectorXd::Constant(1, soft.cost(x));
    });
    EXPECT_LT((numeric.transpose() - l.J.transpose() * l.r).norm(), 1e-5 * (1.0 + numeric.norm()));
  }
}

TEST(SoftMixture, FreeEnergyBoundsItFromAbove) {
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const auto components = three_components(random);
    const SoftMixture soft(components);
    const Values at = three_poses(random), elsewhere = three_poses(random);
    const Eigen::VectorXd g = soft.weights(at);
    const auto free_energy = [&](const Values& values) {
      const auto c = component_costs(components, values);
      double sum = 0.0;
      for (int k = 0; k < 3; ++k) sum += g[k] * (c[k] + std::log(std::max(g[k], 1e-300)));
      return sum - soft.log_normalizer();
    };
    EXPECT_NEAR(free_energy(at), soft.cost(at), 1e-9 * (1.0 + soft.cost(at)));
    EXPECT_GE(free_energy(elsewhere), soft.cost(elsewhere) - 1e-9);
  }
}

TEST(SoftMixture, ItsLimitIsTheMaxMixture) {
  Random random(4);
  for (int trial = 0; trial < 10; ++trial) {
    const auto components = three_components(random);
    const Values values = three_poses(random);
    const auto costs = component_costs(components, values);
    const double least = *std::min_element(costs.begin(), costs.end());
    double last = std::numeric_limits<double>::infinity();
    for (double temperature : {1.0, 0.1, 0.01, 1e-4}) {
      const SoftMixture soft(components, temperature);
      const double gap = std::abs(soft.cost(values) + soft.log_normalizer() - least);
      EXPECT_LE(gap, temperature * std::log(3.0) + 1e-12);
      EXPECT_LE(gap, last + 1e-12);
      last = gap;
    }
    const Mixture max({{Key('d', 0), 3}}, components);
    const auto table = max.given(values).front().costs();
    EXPECT_NEAR(*std::min_element(table.begin(), table.end()), least, 1e-12);
    Eigen::Index best = 0;
    SoftMixture(components, 1e-4).weights(values).maxCoeff(&best);
    EXPECT_EQ(costs[static_cast<std::size_t>(best)], least);
  }
}

TEST(SoftMixture, RejectsBadInput) {
  Random random(5);
  EXPECT_THROW(SoftMixture({}), Error);
  EXPECT_THROW(SoftMixture({{nullptr, 1.0}}), Error);
  EXPECT_THROW(SoftMixture(three_components(random), 0.0), Error);
  auto components = three_components(random);
  components[0].constant = std::numeric_limits<double>::infinity();
  EXPECT_THROW(SoftMixture{components}, Error);
}

/// A chain of poses; every third closure is far off, each is soft. A class variable hangs on the
/// first, so that the alternation has a discrete half too.
struct SoftChain {
  HybridGraph graph;
  Estimate start;
  std::vector<Delta> steps;
  Values truth;

  SoftChain() {
    Random random(6);
    const SE2 step(1.0, 0.1, 0.2);
    SE2 T, guess;
    for (int i = 0; i < 30; ++i) {
      Delta delta;
      const Key key('x', i);
      truth.insert(key, T);
      delta.values.insert(key, guess);
      if (i == 0) {
        const DiscreteKey what{Key('s', 0), 2};
        delta.hybrid.push_back(std::make_shared<WeightedFactor>(
            std::make_shared<Prior<SE2>>(key, T, Noise::isotropic(3, 1e-3)),
            Table({what}, {2.0, 1.0})));
        start.assignment.set(what.key, 0);
      } else {
        const SE2 z = step * SE2::exp(random.vector<3>(0.02));
        delta.continuous.push_back(
            std::make_shared<BetweenSE2>(Key('x', i - 1), key, z, Noise::isotropic(3, 0.02)));
      }
      if (i >= 6) {
        const Key old('x', i - 6);
        SE2 z = truth.at<SE2>(old).between(T) * SE2::exp(random.vector<3>(0.02));
        if (i % 3 == 0) z = z * SE2(3.0, -2.0, 1.0);
        delta.continuous.push_back(std::make_shared<SoftMixture>(std::vector<MixtureComponent>{
            {std::make_shared<BetweenSE2>(old, key, z, Noise::isotropic(3, 0.02)), std::log(2.0)},
            {std::make_shared<BetweenSE2>(old, key, z, Noise::isotropic(3, 5.0)), std::log(2.0)}}));
      }
      for (const auto& f : delta.continuous) graph.add(f);
      for (const auto& f : delta.hybrid) graph.add(f);
      start.values.insert(key, guess);
      steps.push_back(std::move(delta));
      T = T * step;
      guess = guess * step * SE2::exp(random.vector<3>(0.02));
    }
  }

  double error(const Values& values) const {
    double worst = 0.0;
    for (Key key : truth.keys()) {
      worst = std::max(
          worst, (truth.at<SE2>(key).translation() - values.at<SE2>(key).translation()).norm());
    }
    return worst;
  }
};

TEST(SoftMixture, AlternationAndSmootherNeverRiseAndEndAtAMinimum) {
  const SoftChain chain;
  const AlternatingResult batch = alternate(chain.graph, chain.start);
  for (std::size_t i = 1; i < batch.report.half_steps.size(); ++i) {
    EXPECT_LE(batch.report.half_steps[i].objective,
              batch.report.half_steps[i - 1].objective + 1e-9);
  }
  EXPECT_EQ(batch.estimate.assignment.at(Key('s', 0)), 1);
  EXPECT_LT(chain.error(batch.estimate.values), 0.2);
  IncrementalSmoother smoother;
  for (const Delta& delta : chain.steps) {
    const UpdateReport report = smoother.update(delta);
    ASSERT_EQ(report.status, UpdateReport::Status::kOk);
    for (std::size_t i = 1; i < report.objectives.size(); ++i) {
      EXPECT_LE(report.objectives[i], report.objectives[i - 1] + 1e-9);
    }
  }
  smoother.converge();
  // It stops where batch solving would: online and from the end it may be another minimum.
  const AlternatingResult again = alternate(chain.graph, smoother.estimate());
  EXPECT_NEAR(smoother.objective(), again.report.objective, 1e-5);
  EXPECT_LT(chain.error(smoother.values()), 0.5);
}

}  // namespace
}  // namespace hybrid
