// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <vector>

#include "libhybrid/discrete/inference.h"

namespace hybrid::testing {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

inline std::vector<const Table*> pointers(const std::vector<Table>& tables) {
  std::vector<const Table*> result;
  for (const Table& table : tables) result.push_back(&table);
  return result;
}

inline double total_cost(const std::vector<Table>& tables, const Assignment& assignment) {
  double sum = 0.0;
  for (const Table& table : tables) sum += table.cost(assignment);
  return sum;
}

inline DiscreteKey binary(int i) {
  return {Key('d', i), 2};
}

/// A table of costs in [-3, 3], whole numbers if `ties`, infinite with the given probability.
template <class Random>
Table random_table(const std::vector<DiscreteKey>& keys, double impossible, bool ties,
                   Random& rng) {
  std::uniform_real_distribution<double> cost(-3.0, 3.0);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<double> costs(joint_size(keys));
  for (double& c : costs) {
    c = ties ? std::round(cost(rng)) : cost(rng);
    if (unit(rng) < impossible) c = kInfinity;
  }
  return {keys, costs};
}

/// Up to 8 tables over up to 4 of up to 7 variables with 1 to 4 values.
template <class Random>
std::vector<Table> random_tables(double impossible, bool ties, Random& rng) {
  const auto draw = [&](int low, int high) {
    return std::uniform_int_distribution<int>(low, high)(rng);
  };
  std::vector<DiscreteKey> variables;
  const int n = draw(1, 7);
  for (int i = 0; i < n; ++i) variables.push_back({Key('d', i), draw(0, 9) == 0 ? 1 : draw(2, 4)});
  std::vector<Table> tables;
  const int m = draw(1, 8);
  for (int t = 0; t < m; ++t) {
    std::shuffle(variables.begin(), variables.end(), rng);
    const int arity = std::min(n, draw(1, 4));
    tables.push_back(
        random_table({variables.begin(), variables.begin() + arity}, impossible, ties, rng));
  }
  return tables;
}

/// The variables of some tables, by key.
inline std::map<Key, int> variables_of(const std::vector<Table>& tables) {
  std::map<Key, int> variables;
  for (const Table& table : tables) {
    for (const DiscreteKey& key : table.keys()) variables[key.key] = key.cardinality;
  }
  return variables;
}

/// Calls a function with every joint value of the variables.
template <class Function>
void for_each_assignment(const std::map<Key, int>& variables, Function&& function) {
  Assignment assignment;
  for (const auto& [key, n] : variables) assignment.set(key, 0);
  while (true) {
    function(assignment);
    auto it = variables.begin();
    while (it != variables.end() && assignment.at(it->first) + 1 == it->second) {
      assignment.set(it->first, 0);
      ++it;
    }
    if (it == variables.end()) return;
    assignment.set(it->first, assignment.at(it->first) + 1);
  }
}

}  // namespace hybrid::testing
