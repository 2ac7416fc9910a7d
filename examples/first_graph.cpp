// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A robot drives one metre; a loop closure measures five. Solves for the poses and decides about
// the closure.
#include <iostream>
#include <memory>

#include "libhybrid/hybrid.h"

int main() {
  using namespace hybrid;
  // [example]
  const Key a{'x', 0}, b{'x', 1};
  const DiscreteKey trusted{{'d', 0}, 2};  // 0: the loop closure is right, 1: it is an outlier
  const Noise noise = Noise::isotropic(3, 0.1);
  HybridGraph graph;
  graph.emplace<Prior<SE2>>(a, SE2(0, 0, 0), noise);
  graph.emplace<BetweenSE2>(a, b, SE2(1, 0, 0), noise);
  // Of an outlier nothing is known: 1e4 times the covariance. One in ten is expected to be one.
  const auto loop = std::make_shared<BetweenSE2>(a, b, SE2(5, 0, 0), noise);
  const auto wide = std::make_shared<BetweenSE2>(a, b, SE2(5, 0, 0), noise.inflated(1e4));
  graph.add(make_outlier_mixture(trusted, loop, wide, 0.9, 0.1));

  Estimate initial;
  initial.values.insert(a, SE2());
  initial.values.insert(b, SE2(4, 0, 0));
  initial.assignment.set(trusted.key, 0);
  const Estimate best = alternate(graph, initial).estimate;
  const ContinuousMarginals marginals(graph, best);
  std::cout << "b is at x = " << best.values.at<SE2>(b).x() << " m, sigma "
            << std::sqrt(marginals.covariance(b)(0, 0))
            << " m; the closure is false with probability "
            << posterior(graph, best, {trusted.key}).at(trusted.key).p[1] << '\n';
  // [example]
  return best.assignment.at(trusted.key) == 1 ? 0 : 1;
}
