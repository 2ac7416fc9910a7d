// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/discrete.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

TEST(DiscreteMarginals, EqualEnumerationOfTheJointObjective) {
  const auto s = testing::simulate_outliers(12, 6, 0.4, true, 1);
  const std::vector<DiscreteKey> keys = s.graph.discrete_keys();
  std::vector<double> ones(keys.size(), 0.0);
  double total = 0.0;
  const double base = objective(s.graph, s.initial.values, s.initial.assignment);
  for (std::size_t code = 0; code < (std::size_t(1) << keys.size()); ++code) {
    Assignment assignment;
    for (std::size_t i = 0; i < keys.size(); ++i) assignment.set(keys[i].key, (code >> i) & 1);
    const double p = std::exp(base - objective(s.graph, s.initial.values, assignment));
    total += p;
    for (std::size_t i = 0; i < keys.size(); ++i) ones[i] += (code >> i) & 1 ? p : 0.0;
  }
  const DiscreteMarginals marginals = discrete_marginals(s.graph, s.initial.values);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    EXPECT_NEAR(marginals.at(keys[i].key)[1], ones[i] / total, 1e-9);
  }
}

}  // namespace
}  // namespace hybrid
