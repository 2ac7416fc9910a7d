// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// A landmark with a class, seen three times by a detector that is often wrong (eq. 19), and the
// class of its neighbour, which was never seen.
#include <iostream>
#include <vector>

#include "libhybrid/discrete/probabilities.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/semantic.h"
#include "libhybrid/marginals/discrete.h"
#include "libhybrid/solvers/alternating.h"

int main() {
  using namespace hybrid;
  const Key pose('x', 0), point('l', 0);
  const DiscreteKey kind{{'s', 0}, 3};  // tree, car, pole
  const DiscreteKey neighbour{{'s', 1}, 3};
  HybridGraph graph;
  graph.add(prior_table(kind, {0.5, 0.3, 0.2}));
  graph.add(conditional_table(neighbour, {kind},  // trees stand by trees, cars rarely by poles
                              {0.7, 0.2, 0.1,     //
                               0.3, 0.6, 0.1,     //
                               0.5, 0.1, 0.4}));
  graph.emplace<Prior<SE2>>(pose, SE2(), Noise::isotropic(3, 0.01));
  const std::vector<std::vector<double>> scores = {
      {0.6, 0.3, 0.1}, {0.3, 0.5, 0.2}, {0.7, 0.2, 0.1}};
  for (const std::vector<double>& phi : scores) {
    graph.add(make_semantic_bearing_range<SE2>(pose, point, kind, Eigen::Vector2d(4.0, 0.5),
                                               Noise::diagonal(Eigen::Vector2d(0.1, 0.02)), phi));
  }
  Estimate initial;
  initial.values.insert(pose, SE2());
  initial.values.insert(point, Eigen::Vector2d(3, 1));
  initial.assignment.set(kind.key, 0);
  initial.assignment.set(neighbour.key, 0);
  const Estimate best = alternate(graph, initial).estimate;
  const auto marginals = discrete_marginals(graph, best.values);
  for (const DiscreteKey& key : {kind, neighbour}) {
    const Eigen::VectorXd p = marginals.at(key.key);
    std::cout << to_string(key.key) << ": tree " << p[0] << ", car " << p[1] << ", pole " << p[2]
              << '\n';
  }
  return best.assignment.at(kind.key) == 0 ? 0 : 1;
}
