// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// What is solved around touched variables is what solving all of them gives.
#include "libhybrid/smoother/discrete_half.h"

#include <gtest/gtest.h>

#include <iterator>
#include <limits>
#include <map>
#include <vector>

#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::Random;

DiscreteKey mode(int i) {
  return {Key('m', static_cast<std::uint64_t>(i)), 2 + i % 2};
}

Table random_table(const std::vector<DiscreteKey>& keys, double spread, Random& random,
                   bool may_exclude) {
  std::vector<double> costs(joint_size(keys));
  for (double& cost : costs) cost = spread * random.uniform();
  if (may_exclude && random.below(4) == 0) {
    costs[random.below(static_cast<int>(costs.size()))] = std::numeric_limits<double>::infinity();
  }
  return Table(keys, costs);
}

/// A discrete half and, beside it, all tables that it was given.
class Checked {
 public:
  void add(const std::vector<DiscreteKey>& keys, const Table& table) {
    const int f = half_.add(keys, -1, {});
    set(f, table);
  }
  void set(int f, const Table& table) {
    half_.set_tables(f, {table});
    tables_[f] = table;
  }
  void remove(int f) {
    half_.remove(f);
    tables_.erase(f);
  }
  /// One of the factors.
  int any(Random& random) const {
    return std::next(tables_.begin(), random.below(static_cast<int>(tables_.size())))->first;
  }
  const std::vector<DiscreteKey>& keys(int f) const { return tables_.at(f).keys(); }
  const Assignment& assignment() const { return half_.assignment(); }

  /// Calls change(), solves, and takes all of that back.
  template <class Change>
  void try_out(const Change& change) {
    const Assignment before = assignment();
    const std::map<int, Table> tables = tables_;
    const DiscreteHalf::Mark mark = half_.mark();
    change();
    half_.solve({});
    expect_least();
    half_.roll_back(mark);
    tables_ = tables;
    EXPECT_EQ(assignment(), before);
  }

  DiscreteHalf::Report solve() {
    const DiscreteHalf::Report report = half_.solve({});
    half_.commit();
    return report;
  }

  void expect_least() const {
    std::vector<const Table*> all;
    for (const auto& [f, table] : tables_) all.push_back(&table);
    const DiscreteSolution whole = solve_discrete(all);
    double cost = 0.0;
    for (const Table* table : all) cost += table->cost(half_.assignment());
    EXPECT_NEAR(cost, whole.cost, 1e-9);
  }

 private:
  DiscreteHalf half_;
  std::map<int, Table> tables_;
};

class RandomGraphs : public ::testing::TestWithParam<double> {};

TEST_P(RandomGraphs, AreSolvedWholly) {
  const double coupling = GetParam();
  for (int seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Checked graph;
    for (int i = 0; i < 120; ++i) {
      graph.add({mode(i)}, random_table({mode(i)}, 3.0, random, false));
      if (i > 0) {
        // Mostly a chain, with some links back.
        const int to = random.below(10) == 0 ? random.below(i) : i - 1;
        const std::vector<DiscreteKey> keys = {mode(to), mode(i)};
        graph.add(keys, random_table(keys, coupling, random, true));
      }
      if (i % 20 == 19) {
        const std::vector<DiscreteKey> keys = {mode(i), mode(i - 1), mode(i - 2)};
        graph.add(keys, random_table(keys, coupling, random, true));
      }
      const auto change = [&] {
        const int f = graph.any(random);
        const std::vector<DiscreteKey> keys = graph.keys(f);
        graph.set(f, random_table(keys, keys.size() == 1 ? 3.0 : coupling, random, false));
      };
      for (int changes = random.below(4); changes > 0; --changes) change();
      if (random.below(5) == 0) graph.try_out(change);
      if (i > 0 && random.below(5) == 0) {
        graph.try_out([&] {
          graph.add({mode(i), mode(i / 2)},
                    random_table({mode(i), mode(i / 2)}, coupling, random, false));
          graph.add({mode(1000)}, random_table({mode(1000)}, coupling, random, false));
        });
      }
      if (random.below(12) == 0) graph.remove(graph.any(random));
      graph.solve();
      graph.expect_least();
      if (HasFailure()) FAIL() << "seed " << seed << ", step " << i;
    }
  }
}

TEST(DiscreteHalf, WhatIsTooWideForMessagesIsSolvedWholly) {
  // Many variables, each tied to one that came first, and to the one before.
  Random random(5);
  Checked graph;
  for (int i = 0; i < 150; ++i) {
    graph.add({mode(i)}, random_table({mode(i)}, 3.0, random, false));
    if (i == 0) continue;
    graph.add({mode(0), mode(i)}, random_table({mode(0), mode(i)}, 1.0, random, false));
    graph.add({mode(i - 1), mode(i)}, random_table({mode(i - 1), mode(i)}, 1.0, random, false));
    graph.solve();
    if (i % 10 == 0) graph.expect_least();
  }
  // Another large component, which is not, and then both in one.
  for (int i = 200; i < 300; ++i) {
    graph.add({mode(i)}, random_table({mode(i)}, 3.0, random, false));
    if (i == 200) continue;
    graph.add({mode(i - 1), mode(i)}, random_table({mode(i - 1), mode(i)}, 1.0, random, false));
    graph.solve();
  }
  graph.expect_least();
  graph.add({mode(10), mode(250)}, random_table({mode(10), mode(250)}, 9.0, random, false));
  graph.solve();
  graph.expect_least();
}

INSTANTIATE_TEST_SUITE_P(Couplings, RandomGraphs, ::testing::Values(0.5, 3.0, 20.0));

/// Adds variable i of a chain of two values each, with the cost of the second one, and those of
/// being equal to the variable before and not.
void extend_chain(Checked& graph, int i, double second, double equal, double other) {
  const auto variable = [](int k) {
    return DiscreteKey{Key('m', static_cast<std::uint64_t>(k)), 2};
  };
  graph.add({variable(i)}, Table({variable(i)}, {0.0, second}));
  if (i == 0) return;
  const std::vector<DiscreteKey> both = {variable(i - 1), variable(i)};
  graph.add(both, Table(both, {equal, other, other, equal}));
}

TEST(DiscreteHalf, WorkOfAStepDoesNotGrowWithAChainWhoseValuesAreClear) {
  Random random(3);
  Checked graph;
  for (int i = 0; i < 5000; ++i) {
    extend_chain(graph, i, random.uniform(-6.0, 12.0), 0.05, 3.0);
    EXPECT_LT(graph.solve().variables, 150) << "step " << i;
  }
  graph.expect_least();
}

TEST(DiscreteHalf, AnUndecidedChainIsSolvedAsFarAsItGoes) {
  Checked graph;
  for (int i = 0; i < 300; ++i) {
    extend_chain(graph, i, 0.0, 0.0, 3.0);
  }
  graph.solve();
  // One value at the end is told, and all the others follow.
  const DiscreteKey end{Key('m', 299), 2};
  graph.add({end}, Table({end}, {1.0, 0.0}));
  EXPECT_EQ(graph.solve().flips.size(), 300);
  graph.expect_least();
}

TEST(DiscreteHalf, WhatIsImpossibleAtPresentBoundsNothing) {
  const double never = std::numeric_limits<double>::infinity();
  Checked graph;
  // A chain in which a value reaches only its equal: all of it follows the one that is told.
  for (int i = 0; i < 100; ++i) {
    extend_chain(graph, i, 0.001, 0.0, never);
  }
  graph.solve();
  const DiscreteKey middle{Key('m', 50), 2};
  graph.add({middle}, Table({middle}, {1.0, 0.0}));
  EXPECT_EQ(graph.solve().flips.size(), 100);
  graph.expect_least();
}

}  // namespace
}  // namespace hybrid
