// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/discrete/inference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

#include "libhybrid/discrete/graph.h"
#include "tests/libhybrid/discrete/random_tables.h"

namespace hybrid {
namespace {

using testing::binary;
using testing::for_each_assignment;
using testing::kInfinity;
using testing::pointers;
using testing::random_table;
using testing::random_tables;
using testing::total_cost;
using testing::variables_of;

std::string error_of(const std::function<void()>& function) {
  try {
    function();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(SolveDiscrete, FindsTheMinimumOfEnumeration) {
  std::mt19937 rng(1);
  int impossible_graphs = 0;
  for (int trial = 0; trial < 600; ++trial) {
    const std::vector<Table> tables = random_tables(trial % 3 * 0.15, trial % 2 == 0, rng);
    double best = kInfinity;
    for_each_assignment(variables_of(tables), [&](const Assignment& assignment) {
      best = std::min(best, total_cost(tables, assignment));
    });
    const DiscreteSolution solution = solve_discrete(pointers(tables));
    EXPECT_TRUE(solution.exact);
    EXPECT_EQ(solution.assignment.size(), variables_of(tables).size());
    EXPECT_EQ(solution.cost == kInfinity, !solution.impossible.empty());
    if (best == kInfinity) {
      ++impossible_graphs;
      EXPECT_EQ(solution.cost, kInfinity);
    } else {
      EXPECT_NEAR(solution.cost, best, 1e-9);
      EXPECT_NEAR(total_cost(tables, solution.assignment), best, 1e-9);
    }
  }
  EXPECT_GT(impossible_graphs, 5);
  EXPECT_LT(impossible_graphs, 200);
}

TEST(SolveDiscrete, KeepsAnIncumbentThatIsAsGoodAsAny) {
  std::mt19937 rng(2);
  int with_ties = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const std::vector<Table> tables = random_tables(trial % 2 * 0.1, true, rng);
    const double best = solve_discrete(pointers(tables)).cost;
    int optimal = 0;
    for_each_assignment(variables_of(tables), [&](const Assignment& assignment) {
      if (total_cost(tables, assignment) > best || ++optimal > 20) return;
      const DiscreteSolution again = solve_discrete(pointers(tables), {}, &assignment);
      EXPECT_TRUE(again.assignment == assignment);
      EXPECT_TRUE(again.changed.empty());
    });
    with_ties += optimal > 1;
  }
  EXPECT_GT(with_ties, 60);
}

TEST(SolveDiscrete, MovesOnlyWhatLowersTheCost) {
  const std::vector<Table> tables{Table({binary(0)}, {1.0, 0.0}),
                                  Table({binary(0), binary(1)}, {0.0, 0.0, 0.0, 0.0}),
                                  Table({binary(1), binary(2)}, {0.0, 0.0, 0.0, 0.0})};
  Assignment ones;
  ones.set(binary(0).key, 0);
  ones.set(binary(1).key, 1);
  ones.set(binary(2).key, 1);
  EXPECT_EQ(solve_discrete(pointers(tables), {}, &ones).changed, std::vector<Key>{binary(0).key});
}

TEST(SolveDiscrete, ReportsWhatChanged) {
  const std::vector<Table> tables{Table({binary(0)}, {1.0, 0.0}), Table({binary(1)}, {0.0, 1.0}),
                                  Table({binary(2)}, {0.0, 1.0})};
  Assignment assignment;
  assignment.set(Key('d', 0), 0);
  assignment.set(Key('d', 1), 0);
  assignment.set(Key('z', 9), 5);
  const DiscreteReport report = update_assignment(pointers(tables), {}, assignment);
  EXPECT_EQ(report.changed, (std::vector<Key>{Key('d', 0), Key('d', 2)}));
  EXPECT_EQ(assignment.at(Key('d', 0)), 1);
  EXPECT_EQ(assignment.at(Key('z', 9)), 5);
}

TEST(SolveDiscrete, IgnoresAnIncumbentOutOfRange) {
  const std::vector<Table> tables{Table({binary(0)}, {1.0, 0.0})};
  Assignment assignment;
  assignment.set(Key('d', 0), 7);
  EXPECT_EQ(solve_discrete(pointers(tables), {}, &assignment).assignment.at(Key('d', 0)), 1);
}

TEST(SolveDiscrete, NamesTheVariablesOfAContradiction) {
  const std::vector<Table> tables{Table({binary(0), binary(1)}, {0.0, kInfinity, kInfinity, 0.0}),
                                  Table({binary(0), binary(1)}, {kInfinity, 0.0, 0.0, kInfinity}),
                                  Table({binary(2), binary(3)}, {3.0, 2.0, 1.0, 4.0})};
  const DiscreteSolution solution = solve_discrete(pointers(tables));
  std::vector<Key> named = solution.impossible;
  std::sort(named.begin(), named.end());
  EXPECT_EQ(named, (std::vector<Key>{Key('d', 0), Key('d', 1)}));
  EXPECT_EQ(solution.cost, kInfinity);
  EXPECT_EQ(solution.assignment.at(Key('d', 2)), 1);
  EXPECT_EQ(solution.assignment.at(Key('d', 3)), 0);
  const std::string message = error_of([&] { discrete_marginals(pointers(tables)); });
  EXPECT_NE(message.find("d0"), std::string::npos) << message;
  EXPECT_NE(message.find("d1"), std::string::npos) << message;
}

TEST(SolveDiscrete, CountsTablesWithoutVariables) {
  const std::vector<Table> tables{Table({}, {2.5}), Table(), Table({binary(0)}, {1.0, 0.5})};
  EXPECT_DOUBLE_EQ(solve_discrete(pointers(tables)).cost, 3.0);
  EXPECT_NEAR(discrete_marginals(pointers(tables)).log_partition(),
              -2.5 + std::log(std::exp(-1.0) + std::exp(-0.5)), 1e-12);
  EXPECT_DOUBLE_EQ(solve_discrete({}).cost, 0.0);
}

TEST(SolveDiscrete, RefusesTablesThatDisagree) {
  const std::vector<Table> tables{Table({{Key('d', 0), 2}}, {1.0, 0.0}),
                                  Table({{Key('d', 0), 3}}, {1.0, 0.0, 2.0})};
  const std::string message = error_of([&] { solve_discrete(pointers(tables)); });
  EXPECT_NE(message.find("d0"), std::string::npos) << message;
}

TEST(DiscreteMarginals, EqualBruteForce) {
  std::mt19937 rng(3);
  for (int trial = 0; trial < 400; ++trial) {
    const std::vector<Table> tables = random_tables(trial % 3 * 0.1, false, rng);
    std::map<Key, std::vector<double>> expected;
    for (const auto& [key, n] : variables_of(tables)) expected[key].assign(n, 0.0);
    double sum = 0.0;
    for_each_assignment(variables_of(tables), [&](const Assignment& assignment) {
      const double p = std::exp(-total_cost(tables, assignment));
      sum += p;
      for (auto& [key, marginal] : expected) marginal[assignment.at(key)] += p;
    });
    if (sum == 0.0) {
      EXPECT_THROW(discrete_marginals(pointers(tables)), Error);
      continue;
    }
    const DiscreteMarginals marginals = discrete_marginals(pointers(tables));
    EXPECT_NEAR(marginals.log_partition(), std::log(sum), 1e-9);
    EXPECT_EQ(marginals.size(), expected.size());
    for (const auto& [key, marginal] : expected) {
      ASSERT_EQ(marginals.at(key).size(), static_cast<int>(marginal.size()));
      for (std::size_t i = 0; i < marginal.size(); ++i) {
        EXPECT_NEAR(marginals.at(key)[i], marginal[i] / sum, 1e-9);
      }
    }
  }
}

TEST(DiscreteMarginals, JointOfChosenVariablesEqualsBruteForce) {
  std::mt19937 rng(4);
  for (int trial = 0; trial < 200; ++trial) {
    const std::vector<Table> tables = random_tables(0.0, false, rng);
    std::vector<DiscreteKey> chosen;
    for (const auto& [key, n] : variables_of(tables)) chosen.push_back({key, n});
    std::shuffle(chosen.begin(), chosen.end(), rng);
    if (chosen.size() > 3) chosen.resize(3);
    std::vector<Key> keys;
    for (const DiscreteKey& key : chosen) keys.push_back(key.key);
    std::vector<double> expected(joint_size(chosen), 0.0);
    double sum = 0.0;
    for_each_assignment(variables_of(tables), [&](const Assignment& assignment) {
      const double p = std::exp(-total_cost(tables, assignment));
      expected[joint_index(chosen, assignment)] += p;
      sum += p;
    });
    const std::vector<double> joint = joint_marginal(pointers(tables), keys);
    ASSERT_EQ(joint.size(), expected.size());
    for (std::size_t i = 0; i < joint.size(); ++i) EXPECT_NEAR(joint[i], expected[i] / sum, 1e-9);
  }
}

TEST(DiscreteMarginals, NameWhatIsUnknown) {
  const std::vector<Table> tables{Table({binary(0)}, {1.0, 0.0})};
  EXPECT_THROW(discrete_marginals(pointers(tables)).at(Key('d', 5)), Error);
  EXPECT_THROW(joint_marginal(pointers(tables), {Key('d', 5)}), Error);
}

TEST(ConnectedComponents, GroupTables) {
  const std::vector<Table> tables{
      Table({binary(0), binary(1)}, {0, 0, 0, 0}), Table({binary(5)}, {0, 0}), Table({}, {1.0}),
      Table({binary(1), binary(2)}, {0, 0, 0, 0}), Table({binary(4), binary(3)}, {0, 0, 0, 0})};
  EXPECT_EQ(connected_components(pointers(tables)),
            (std::vector<std::vector<int>>{{0, 3}, {1}, {4}}));
}

// An association of n candidates tied to the class of each: exact inference must not join the
// classes.
TEST(SolveDiscrete, EliminatesClassesBeforeTheAssociationThatTiesThem) {
  std::mt19937 rng(6);
  const int n = 60;
  const DiscreteKey association{Key('a', 0), n};
  std::vector<Table> tables;
  for (int h = 0; h < n; ++h) {
    tables.push_back(random_table({association, {Key('s', h), 4}}, 0.0, false, rng));
  }
  double best = kInfinity;
  for (int a = 0; a < n; ++a) {
    double sum = 0.0;
    for (const Table& table : tables) {
      const auto row = table.costs().begin() + a * 4;
      sum += *std::min_element(row, row + 4);
    }
    best = std::min(best, sum);
  }
  DiscreteOptions options;
  options.max_table = n * 4;
  options.local_search_when_too_large = false;
  EXPECT_NEAR(solve_discrete(pointers(tables), options).cost, best, 1e-9);
}

// Every new variable joins a clique of four: an order exists that adds no edge, and is found.
TEST(SolveDiscrete, AddsNoEdgeToAChordalGraph) {
  std::mt19937 rng(7);
  std::vector<std::vector<int>> cliques{{0, 1, 2, 3}};
  std::vector<Table> tables;
  for (int v = 4; v < 200; ++v) {
    std::vector<int> clique = cliques[rng() % cliques.size()];
    clique[rng() % clique.size()] = v;
    for (int u : clique) {
      if (u != v) tables.push_back(random_table({binary(u), binary(v)}, 0.0, false, rng));
    }
    cliques.push_back(std::move(clique));
  }
  DiscreteOptions options;
  options.max_table = 16;
  options.local_search_when_too_large = false;
  const DiscreteSolution solution = solve_discrete(pointers(tables), options);
  EXPECT_TRUE(solution.exact);
  EXPECT_NEAR(solution.cost, total_cost(tables, solution.assignment), 1e-9);
}

}  // namespace
}  // namespace hybrid
