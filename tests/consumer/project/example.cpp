// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <iostream>
#include <memory>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/hybrid/mixture.h"

// The example of the README: an odometry step and a loop closure that may be wrong.
int main() {
  using namespace hybrid;
  const Key a{'x', 0}, b{'x', 1};
  const DiscreteKey trusted{{'d', 0}, 2};  // 0: the loop closure is right, 1: it is an outlier
  const Noise noise = Noise::isotropic(3, 0.1);
  HybridGraph graph;
  graph.emplace<Prior<SE2>>(a, SE2(0, 0, 0), noise);
  graph.emplace<BetweenSE2>(a, b, SE2(1, 0, 0), noise);
  const auto loop = std::make_shared<BetweenSE2>(a, b, SE2(5, 0, 0), noise);
  const auto wide = std::make_shared<BetweenSE2>(a, b, SE2(5, 0, 0), noise.inflated(1e4));
  graph.add(make_outlier_mixture(trusted, loop, wide, 0.9, 0.1));

  Values values;
  values.insert(a, SE2(0, 0, 0));
  values.insert(b, SE2(1, 0, 0));
  Assignment right, wrong;
  right.set(trusted.key, 0);
  wrong.set(trusted.key, 1);
  std::cout << "objective if trusted " << objective(graph, values, right) << ", if not "
            << objective(graph, values, wrong) << '\n';
  return objective(graph, values, wrong) < objective(graph, values, right) ? 0 : 1;
}
