// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/marginals/evidence.h"
#include "libhybrid/marginals/posterior.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

TEST(PosteriorOfComponents, TakeModesOfOtherComponentsAsTheyAreEstimated) {
  // Two modes that only a scalar connects: each measurement is near -1 or near 1.
  using Vector1 = Eigen::Matrix<double, 1, 1>;
  const Key x('x', 0);
  const auto prior = [&](double z, double sigma) {
    return std::make_shared<Prior<Vector1>>(x, Vector1(z), Noise::isotropic(1, sigma));
  };
  HybridGraph graph;
  Estimate estimate;
  estimate.values.insert(x, Vector1(0.0));
  graph.add(prior(0.2, 1.0));
  std::vector<Key> keys;
  for (int i = 0; i < 2; ++i) {
    const DiscreteKey mode{Key('m', i), 2};
    graph.add(HybridFactorPtr(std::make_shared<Mixture>(
        std::vector<DiscreteKey>{mode},
        std::vector<MixtureComponent>{{prior(-1.0, 0.7)}, {prior(1.0, 0.7 + 0.1 * i)}})));
    keys.push_back(mode.key);
    estimate.assignment.set(keys.back(), 1);
  }
  double joint[2][2], sum = 0.0;
  for (int a : {0, 1}) {
    for (int b : {0, 1}) {
      Estimate at = estimate;
      at.assignment.set(keys[0], a);
      at.assignment.set(keys[1], b);
      at.values = levenberg_marquardt(graph, at, {}).values;
      joint[a][b] = std::exp(log_evidence(graph, at).log.value());
      sum += joint[a][b];
      if (a == 1 && b == 1) estimate.values = at.values;
    }
  }
  const double given = joint[1][1] / (joint[0][1] + joint[1][1]);
  const double marginal = (joint[1][0] + joint[1][1]) / sum;
  EXPECT_GT(given, marginal + 0.1);
  EXPECT_NEAR(posterior_marginals(graph, estimate, keys).at(keys[0]).p[1], given, 1e-6);
  EXPECT_NEAR(posterior(graph, estimate, keys).at(keys[0]).p[1], marginal, 1e-6);
}

}  // namespace
}  // namespace hybrid
