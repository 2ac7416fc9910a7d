// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <algorithm>

#include "libhybrid/discrete/inference.h"
#include "tests/libhybrid/discrete/random_tables.h"

namespace hybrid {
namespace {

using testing::pointers;
using testing::random_table;

constexpr int kStates = 3;

DiscreteKey state(int i) {
  return {Key('q', i), kStates};
}

/// Unary tables 0 .. n - 1, then transitions 0 .. n - 2.
std::vector<Table> random_chain(int n, unsigned seed) {
  std::mt19937 rng(seed);
  std::vector<Table> tables;
  tables.reserve(2 * n);
  for (int i = 0; i < n; ++i) tables.push_back(random_table({state(i)}, 0.0, false, rng));
  for (int i = 0; i + 1 < n; ++i) {
    tables.push_back(random_table({state(i), state(i + 1)}, 0.0, false, rng));
  }
  return tables;
}

std::vector<int> viterbi(const std::vector<Table>& chain, int n) {
  std::vector<double> cost = chain[0].costs();
  std::vector<std::vector<int>> from(n, std::vector<int>(kStates));
  for (int i = 1; i < n; ++i) {
    std::vector<double> next(kStates, testing::kInfinity);
    for (int b = 0; b < kStates; ++b) {
      for (int a = 0; a < kStates; ++a) {
        const double c = cost[a] + chain[n + i - 1].costs()[a * kStates + b];
        if (c < next[b]) next[b] = c, from[i][b] = a;
      }
    }
    for (int b = 0; b < kStates; ++b) cost[b] = next[b] + chain[i].costs()[b];
  }
  std::vector<int> path(n);
  path[n - 1] = static_cast<int>(std::min_element(cost.begin(), cost.end()) - cost.begin());
  for (int i = n - 1; i > 0; --i) path[i - 1] = from[i][path[i]];
  return path;
}

/// Normalised probabilities of every state, by scaled forward and backward recursions.
std::vector<std::vector<double>> forward_backward(const std::vector<Table>& chain, int n) {
  const auto p = [](double cost) { return std::exp(-cost); };
  std::vector<std::vector<double>> forward(n, std::vector<double>(kStates));
  std::vector<std::vector<double>> backward(n, std::vector<double>(kStates, 1.0));
  const auto scale = [](std::vector<double>& v) {
    double sum = 0.0;
    for (double x : v) sum += x;
    for (double& x : v) x /= sum;
  };
  for (int i = 0; i < n; ++i) {
    for (int b = 0; b < kStates; ++b) {
      double sum = i == 0 ? 1.0 : 0.0;
      for (int a = 0; i > 0 && a < kStates; ++a) {
        sum += forward[i - 1][a] * p(chain[n + i - 1].costs()[a * kStates + b]);
      }
      forward[i][b] = sum * p(chain[i].costs()[b]);
    }
    scale(forward[i]);
  }
  for (int i = n - 2; i >= 0; --i) {
    for (int a = 0; a < kStates; ++a) {
      backward[i][a] = 0.0;
      for (int b = 0; b < kStates; ++b) {
        backward[i][a] +=
            p(chain[n + i].costs()[a * kStates + b] + chain[i + 1].costs()[b]) * backward[i + 1][b];
      }
    }
    scale(backward[i]);
  }
  for (int i = 0; i < n; ++i) {
    for (int a = 0; a < kStates; ++a) forward[i][a] *= backward[i][a];
    scale(forward[i]);
  }
  return forward;
}

TEST(Chain, EqualsViterbi) {
  for (int n : {2, 3, 50, 100000}) {
    const std::vector<Table> chain = random_chain(n, n);
    const DiscreteSolution solution = solve_discrete(pointers(chain));
    const std::vector<int> expected = viterbi(chain, n);
    for (int i = 0; i < n; ++i) ASSERT_EQ(solution.assignment.at(state(i).key), expected[i]) << i;
  }
}

TEST(Chain, EqualsForwardBackward) {
  for (int n : {2, 3, 50, 100000}) {
    const std::vector<Table> chain = random_chain(n, n);
    const DiscreteMarginals marginals = discrete_marginals(pointers(chain));
    const auto expected = forward_backward(chain, n);
    for (int i = 0; i < n; ++i) {
      for (int a = 0; a < kStates; ++a) {
        ASSERT_NEAR(marginals.at(state(i).key)[a], expected[i][a], 1e-8) << i;
      }
    }
  }
}

TEST(Chain, OfAMillionNeedsNoRecursion) {
  const int n = 1000000;
  const std::vector<Table> chain = random_chain(n, 5);
  Assignment assignment;
  EXPECT_TRUE(update_assignment(pointers(chain), {}, assignment).exact);
  EXPECT_EQ(assignment.size(), static_cast<std::size_t>(n));
  EXPECT_TRUE(update_assignment(pointers(chain), {}, assignment).changed.empty());
}

// A ring has no leaf, so that all of it goes through the min-fill queue.
TEST(Chain, ClosedToARingIsStillExact) {
  std::mt19937 rng(8);
  for (int n : {3, 4, 9}) {
    std::vector<Table> ring = random_chain(n, n);
    ring.push_back(random_table({state(n - 1), state(0)}, 0.0, false, rng));
    double best = testing::kInfinity;
    testing::for_each_assignment(testing::variables_of(ring), [&](const Assignment& assignment) {
      best = std::min(best, testing::total_cost(ring, assignment));
    });
    DiscreteOptions options;
    options.max_table = kStates * kStates * kStates;
    options.local_search_when_too_large = false;
    EXPECT_NEAR(solve_discrete(pointers(ring), options).cost, best, 1e-9);
  }
}

}  // namespace
}  // namespace hybrid
