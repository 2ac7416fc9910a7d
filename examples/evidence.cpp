// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Did the wheels grip or slip? Compares the evidence of both modes: the density of the measurements
// with the positions integrated out (eq. 12). Here it is exact, since the model is linear.
#include "libhybrid/marginals/evidence.h"

#include <cmath>
#include <iostream>
#include <memory>

#include "libhybrid/discrete/probabilities.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

int main() {
  using namespace hybrid;
  using Metres = Eigen::Matrix<double, 1, 1>;
  const Key before('x', 0), after('x', 1);
  const DiscreteKey wheels{{'m', 0}, 2};  // grip, slip
  const auto moved = [&](double metres, double sigma) {
    return std::make_shared<Between<Metres>>(before, after, Metres(metres),
                                             Noise::isotropic(1, sigma));
  };
  HybridGraph graph;
  graph.emplace<Prior<Metres>>(before, Metres(0.0), Noise::isotropic(1, 0.1));
  graph.emplace<Prior<Metres>>(after, Metres(0.7), Noise::isotropic(1, 0.2));
  graph.add(HybridFactorPtr(std::make_shared<Mixture>(
      std::vector<DiscreteKey>{wheels},
      std::vector<MixtureComponent>{{moved(1.0, 0.05), 0.0}, {moved(0.0, 0.5), 0.0}})));
  graph.add(prior_table(wheels, {0.9, 0.1}));

  std::vector<double> costs;
  for (int mode : {0, 1}) {
    Estimate estimate;
    estimate.values.insert(before, Metres(0.0));
    estimate.values.insert(after, Metres(0.5));
    estimate.assignment.set(wheels.key, mode);
    estimate.values = levenberg_marquardt(graph, estimate, {}).values;  // optimum for this mode
    costs.push_back(-*log_evidence(graph, estimate).log);
    std::cout << (mode == 0 ? "grip" : "slip") << ": evidence " << to_potential(costs.back())
              << '\n';
  }
  const std::vector<double> p = to_probabilities(Table({wheels}, costs));
  std::cout << "the wheels slipped with probability " << p[1] << '\n';

  // By hand: measured are 0.7 m, expected 1 m +- sqrt(0.1^2 + 0.05^2 + 0.2^2) or 0 m +- ...
  const auto density = [](double error, double variance) {
    return std::exp(-0.5 * error * error / variance) / std::sqrt(variance);
  };
  const double grip = 0.9 * density(0.3, 0.01 + 0.0025 + 0.04);
  const double slip = 0.1 * density(0.7, 0.01 + 0.25 + 0.04);
  return std::abs(p[1] - slip / (grip + slip)) < 1e-6 ? 0 : 1;
}
