// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "libhybrid/discrete/inference.h"
#include "libhybrid/discrete/junction_forest.h"
#include "tests/libhybrid/discrete/random_tables.h"

namespace hybrid {
namespace {

using testing::binary;
using testing::for_each_assignment;
using testing::pointers;
using testing::random_table;
using testing::random_tables;
using testing::total_cost;
using testing::variables_of;

/// Every pair of n binary variables shares a table.
std::vector<Table> complete_graph(int n, double impossible, unsigned seed) {
  std::mt19937 rng(seed);
  std::vector<Table> tables;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < i; ++j) {
      tables.push_back(random_table({binary(i), binary(j)}, impossible, false, rng));
    }
  }
  return tables;
}

TEST(TableLimit, IsAnErrorThatNamesVariablesAndSize) {
  const std::vector<Table> tables = complete_graph(10, 0.0, 1);
  DiscreteOptions options;
  options.max_table = 512;
  options.local_search_when_too_large = false;
  for (const bool marginals : {false, true}) {
    try {
      if (marginals) {
        discrete_marginals(pointers(tables), options);
      } else {
        solve_discrete(pointers(tables), options);
      }
      FAIL() << "no error";
    } catch (const Error& error) {
      const std::string message = error.what();
      EXPECT_NE(message.find("1024"), std::string::npos) << message;
      EXPECT_NE(message.find("512"), std::string::npos) << message;
      for (const char* name : {"d0", "d9"}) {
        EXPECT_NE(message.find(name), std::string::npos) << message;
      }
    }
  }
  options.max_table = 1024;
  EXPECT_TRUE(solve_discrete(pointers(tables), options).exact);
}

TEST(TableLimit, HoldsForTheSumOfAllTables) {
  const std::vector<Table> tables = complete_graph(6, 0.0, 1);
  DiscreteOptions options;
  options.local_search_when_too_large = false;
  options.max_total = 64 + 32 + 16 + 8 + 4 + 2;
  EXPECT_TRUE(solve_discrete(pointers(tables), options).exact);
  --options.max_total;
  EXPECT_THROW(solve_discrete(pointers(tables), options), Error);
}

TEST(TableLimit, ConcernsOnlyTheComponentBeyondIt) {
  std::vector<Table> tables = complete_graph(10, 0.0, 2);
  tables.push_back(Table({binary(20), binary(21)}, {3.0, 2.0, 1.0, 4.0}));
  tables.push_back(Table({binary(30)}, {3.0, 2.0}));
  DiscreteOptions options;
  options.max_table = 64;
  const DiscreteSolution solution = solve_discrete(pointers(tables), options);
  EXPECT_FALSE(solution.exact);
  EXPECT_EQ(solution.assignment.size(), 13u);
  EXPECT_EQ(solution.assignment.at(binary(20).key), 1);
  EXPECT_EQ(solution.assignment.at(binary(21).key), 0);
  EXPECT_EQ(solution.assignment.at(binary(30).key), 1);
  EXPECT_NEAR(solution.cost, total_cost(tables, solution.assignment), 1e-9);
}

/// A clique of four variables of 100 values each, too large for any limit here, behind a chain of
/// nine more, whose tables are charged before the clique is met.
std::vector<Table> intractable_component(int first) {
  const auto key = [&](int i) { return DiscreteKey{Key('d', first + i), 100}; };
  std::vector<Table> tables;
  for (int i = 0; i < 13; ++i) {
    for (int j = i < 4 ? 0 : i - 1; j < i; ++j) {
      tables.push_back(Table({key(i), key(j)}, std::vector<double>(10000, 1.0)));
    }
  }
  return tables;
}

TEST(TableLimit, AComponentBeyondItTakesNothingFromTheOthers) {
  DiscreteOptions options;
  options.max_table = 30000;
  options.max_total = 100000;
  const DiscreteKey a{Key('e', 0), 30}, b{Key('e', 1), 30}, c{Key('e', 2), 30};
  for (const bool first : {true, false}) {
    std::vector<Table> tables;
    if (first) tables = intractable_component(0);
    for (const auto& pair : {std::vector{a, b}, std::vector{b, c}, std::vector{a, c}}) {
      tables.push_back(Table(pair, std::vector<double>(900, 1.0)));
    }
    if (!first) {
      for (const Table& table : intractable_component(0)) tables.push_back(table);
    }
    const DiscreteGraph graph(pointers(tables));
    const JunctionForest forest = make_junction_forest(graph, options, true);
    ASSERT_EQ(forest.too_large.size(), 1u);
    EXPECT_EQ(graph.component_variables(forest.too_large[0].component).size(), 13);
    EXPECT_EQ(forest.size(), 3);
  }
}

TEST(TableLimit, OfAllTablesLeavesAsManyComponentsExactAsFit) {
  // Chains of 2 to 6 variables, the largest first: 4 (n - 1) + 2 entries each.
  std::vector<Table> tables;
  for (int n = 6; n >= 2; --n) {
    for (int i = 1; i < n; ++i) {
      tables.push_back(Table({binary(10 * n + i - 1), binary(10 * n + i)}, {0.0, 1.0, 1.0, 0.5}));
    }
  }
  const DiscreteGraph graph(pointers(tables));
  for (const auto& [total, refused] :
       std::vector<std::pair<int, std::size_t>>{{6 + 10 + 14 + 18 + 22, 0},
                                                {6 + 10 + 14 + 18 + 21, 1},
                                                {6 + 10 + 14, 2},
                                                {6, 4},
                                                {5, 5}}) {
    TableLimits limits;
    limits.max_total = total;
    const JunctionForest forest = make_junction_forest(graph, limits, true);
    EXPECT_EQ(forest.too_large.size(), refused) << total;
    std::size_t entries = 0;
    for (std::size_t size : forest.entries) entries += size;
    EXPECT_LE(entries, limits.max_total);
  }
}

TEST(LocalSearch, IsNeverWorseThanTheIncumbent) {
  std::mt19937 rng(3);
  DiscreteOptions options;
  options.max_table = 4;
  int searched = 0, optimal = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const std::vector<Table> tables = random_tables(trial % 2 * 0.1, trial % 4 < 2, rng);
    Assignment incumbent;
    for (const auto& [key, n] : variables_of(tables)) {
      incumbent.set(key, std::uniform_int_distribution<int>(0, n - 1)(rng));
    }
    const DiscreteSolution solution = solve_discrete(pointers(tables), options, &incumbent);
    EXPECT_LE(solution.cost, total_cost(tables, incumbent) + 1e-9);
    if (solution.exact) continue;
    ++searched;
    optimal += solution.cost <= solve_discrete(pointers(tables)).cost + 1e-9;
    const DiscreteSolution again = solve_discrete(pointers(tables), options, &solution.assignment);
    EXPECT_LE(again.cost, solution.cost + 1e-9);
  }
  EXPECT_GT(searched, 100);
  EXPECT_GT(optimal, searched / 2);
}

// One variable at a time cannot leave this start: both must flip together.
TEST(LocalSearch, MovesTreesOfVariablesTogether) {
  std::vector<Table> tables;
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < i; ++j) tables.push_back(Table({binary(i), binary(j)}, {0.1, 0, 0, 0}));
  }
  tables.push_back(Table({binary(0), binary(1)}, {0.0, 50.0, 50.0, -20.0}));
  DiscreteOptions options;
  options.max_table = 16;
  Assignment zeros;
  for (int i = 0; i < 12; ++i) zeros.set(binary(i).key, 0);
  const DiscreteSolution solution = solve_discrete(pointers(tables), options, &zeros);
  EXPECT_FALSE(solution.exact);
  EXPECT_EQ(solution.assignment.at(binary(0).key), 1);
  EXPECT_EQ(solution.assignment.at(binary(1).key), 1);
}

TEST(LocalSearch, LeavesImpossibleStarts) {
  std::vector<Table> tables;
  for (int i = 0; i < 12; ++i) {
    for (int j = 0; j < i; ++j) {
      tables.push_back(Table({binary(i), binary(j)}, {testing::kInfinity, 1.0, 1.0, 2.0}));
    }
  }
  DiscreteOptions options;
  options.max_table = 16;
  EXPECT_NEAR(solve_discrete(pointers(tables), options).cost, 11.0 + 2.0 * 55.0, 1e-9);
}

TEST(LocalSearch, GivesTheSameAnswerTwice) {
  const std::vector<Table> tables = complete_graph(30, 0.05, 9);
  DiscreteOptions options;
  options.max_table = 256;
  const DiscreteSolution first = solve_discrete(pointers(tables), options);
  EXPECT_FALSE(first.exact);
  EXPECT_TRUE(first.assignment == solve_discrete(pointers(tables), options).assignment);
}

}  // namespace
}  // namespace hybrid
