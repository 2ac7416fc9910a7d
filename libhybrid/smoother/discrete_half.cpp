// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/discrete_half.h"

#include <algorithm>
#include <string>
#include <utility>

namespace hybrid {

int DiscreteHalf::add(const std::vector<DiscreteKey>& keys, int owner, const Assignment& initial) {
  int f;
  if (free_.empty()) {
    f = static_cast<int>(factors_.size());
    factors_.emplace_back();
  } else {
    f = free_.back();
    free_.pop_back();
  }
  factors_[f].keys = keys;
  factors_[f].owner = owner;
  for (const DiscreteKey& key : keys) {
    Variable& variable = variables_[key.key];
    if (variable.cardinality == 0) {
      variable.cardinality = key.cardinality;
      assignment_.set(key.key, initial.contains(key.key) ? initial.at(key.key) : 0);
    }
    variable.factors.push_back(f);
  }
  return f;
}

void DiscreteHalf::remove(int f) {
  pure_cost_.subtract(factors_[f].cost);
  for (const DiscreteKey& key : factors_[f].keys) {
    const auto it = variables_.find(key.key);
    std::vector<int>& list = it->second.factors;
    list.erase(std::find(list.begin(), list.end(), f));
    if (list.empty()) {
      variables_.erase(it);
      assignment_.erase(key.key);
    } else {
      touched_.push_back(key.key);
    }
  }
  factors_[f] = {};
  free_.push_back(f);
}

void DiscreteHalf::set_tables(int f, std::vector<Table> tables) {
  factors_[f].tables = std::move(tables);
  for (const DiscreteKey& key : factors_[f].keys) touched_.push_back(key.key);
  refresh_cost(f);
}

void DiscreteHalf::refresh_cost(int f) {
  Factor& factor = factors_[f];
  if (factor.owner >= 0) return;
  pure_cost_.subtract(factor.cost);
  factor.cost = 0.0;
  for (const Table& table : factor.tables) factor.cost += table.cost(assignment_);
  pure_cost_.add(factor.cost);
}

void DiscreteHalf::move(Key key, int value) {
  assignment_.set(key, value);
  for (int f : variables_.at(key).factors) refresh_cost(f);
}

int DiscreteHalf::cardinality(Key key) const {
  const auto it = variables_.find(key);
  if (it == variables_.end()) throw Error("no factor holds discrete variable " + to_string(key));
  return it->second.cardinality;
}

/// Tables of the component of `start`; its variables are marked as visited.
std::vector<const Table*> DiscreteHalf::collect(Key start,
                                                std::unordered_map<Key, bool>* visited) const {
  std::vector<const Table*> tables;
  std::unordered_map<int, bool> taken;
  std::vector<Key> stack = {start};
  (*visited)[start] = true;
  while (!stack.empty()) {
    const Key key = stack.back();
    stack.pop_back();
    for (int f : variables_.at(key).factors) {
      if (!taken.emplace(f, true).second) continue;
      for (const Table& table : factors_[f].tables) tables.push_back(&table);
      for (const DiscreteKey& other : factors_[f].keys) {
        if (visited->emplace(other.key, true).second) stack.push_back(other.key);
      }
    }
  }
  return tables;
}

std::vector<const Table*> DiscreteHalf::component(Key key) const {
  cardinality(key);
  std::unordered_map<Key, bool> visited;
  return collect(key, &visited);
}

/// The common case of a variable that is alone in its component: a plain minimum. False if it is
/// not alone.
bool DiscreteHalf::solve_single(Key key, Report& report) {
  const Variable& variable = variables_.at(key);
  std::vector<double> costs(variable.cardinality, 0.0);
  for (int f : variable.factors) {
    if (factors_[f].keys.size() != 1) return false;
    for (const Table& table : factors_[f].tables) {
      for (std::size_t i = 0; i < costs.size(); ++i) costs[i] += table.costs()[i];
    }
  }
  const int incumbent = assignment_.at(key);
  const int best = static_cast<int>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  ++report.components;
  if (costs[best] < costs[incumbent]) {
    report.flips.push_back({key, incumbent, best});
  }
  return true;
}

DiscreteHalf::Report DiscreteHalf::solve(const DiscreteOptions& options) {
  Report report;
  std::unordered_map<Key, bool> visited;
  for (Key key : touched_) {
    if (variables_.count(key) == 0 || visited.count(key) != 0) continue;
    if (solve_single(key, report)) {
      visited[key] = true;
      continue;
    }
    const std::vector<const Table*> tables = collect(key, &visited);
    const DiscreteSolution solution = solve_discrete(tables, options, &assignment_);
    ++report.components;
    report.exact = report.exact && solution.exact;
    for (const auto& [variable, value] : solution.assignment) {
      const int incumbent = assignment_.at(variable);
      if (value == incumbent) continue;
      report.flips.push_back({variable, incumbent, value});
    }
  }
  for (const Flip& flip : report.flips) move(flip.key, flip.to);
  touched_.clear();
  return report;
}

std::size_t DiscreteHalf::bytes() const {
  std::size_t bytes = factors_.capacity() * sizeof(Factor) +
                      variables_.size() * (sizeof(Key) + sizeof(Variable) + 2 * sizeof(void*));
  for (const Factor& factor : factors_) {
    for (const Table& table : factor.tables) {
      bytes += sizeof(Table) + table.costs().capacity() * sizeof(double) +
               table.keys().capacity() * sizeof(DiscreteKey);
    }
  }
  return bytes;
}

}  // namespace hybrid
