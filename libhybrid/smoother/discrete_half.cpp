// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/discrete_half.h"

#include <algorithm>
#include <string>
#include <utility>

namespace hybrid {

int DiscreteHalf::add(const std::vector<DiscreteKey>& keys, int owner, const Assignment& initial) {
  const int f = numbers_.take();
  if (f >= static_cast<int>(factors_.size())) factors_.resize(f + 1);
  added_.push_back(f);
  factors_[f].keys = keys;
  factors_[f].owner = owner;
  factors_[f].saved = epoch_;
  for (const DiscreteKey& key : keys) {
    Variable& variable = variables_[key.key];
    if (variable.cardinality == 0) {
      assignment_.set(key.key, initial.contains(key.key) ? initial.at(key.key) : 0);
      variable.cardinality = key.cardinality;
    }
    variable.factors.push_back(f);
  }
  return f;
}

void DiscreteHalf::remove(int f) {
  set_tables(f, {});
  removed_.push_back(f);
}

void DiscreteHalf::set_tables(int f, std::vector<Table> tables) {
  Factor& factor = factors_[f];
  for (const DiscreteKey& key : factor.keys) touch(key.key);
  if (factor.saved != epoch_) {
    saved_tables_.emplace_back(f, std::vector<Table>());
    saved_tables_.back().second.swap(factor.tables);
    factor.saved = epoch_;
  }
  factor.tables = std::move(tables);
  refresh_cost(f);
}

/// Forgets a factor, and its variables where no other holds them.
void DiscreteHalf::take_out(int f) {
  for (const DiscreteKey& key : factors_[f].keys) {
    const auto it = variables_.find(key.key);
    if (it == variables_.end()) continue;
    std::vector<int>& list = it->second.factors;
    const auto at = std::find(list.rbegin(), list.rend(), f);
    if (at != list.rend()) list.erase(at.base() - 1);
    if (!list.empty()) continue;
    variables_.erase(it);
    assignment_.erase(key.key);
  }
  factors_[f] = {};
}

void DiscreteHalf::touch(Key key) {
  touched_.push_back(key);
  base_.touched.reserve(touched_.capacity());
}

void DiscreteHalf::commit() noexcept {
  for (int f : removed_) {
    take_out(f);
    numbers_.give(f);
  }
  numbers_.commit();
  start_epoch();
}

DiscreteHalf::Mark DiscreteHalf::mark() {
  Mark mark{
      added_.size(), removed_.size(), saved_tables_.size(), saved_values_.size(), numbers_.mark(),
      pure_cost_,    touched_};
  ++epoch_;
  return mark;
}

void DiscreteHalf::roll_back(const Mark& mark) noexcept {
  for (std::size_t i = saved_tables_.size(); i-- > mark.tables;) {
    factors_[saved_tables_[i].first].tables.swap(saved_tables_[i].second);
  }
  for (std::size_t i = saved_values_.size(); i-- > mark.values;) {
    assignment_.set(saved_values_[i].first, saved_values_[i].second);
  }
  for (; added_.size() > mark.added; added_.pop_back()) take_out(added_.back());
  for (; saved_tables_.size() > mark.tables; saved_tables_.pop_back()) {
    refresh_cost(saved_tables_.back().first);
  }
  for (; saved_values_.size() > mark.values; saved_values_.pop_back()) {
    const auto it = variables_.find(saved_values_.back().first);
    if (it == variables_.end()) continue;
    for (int f : it->second.factors) refresh_cost(f);
  }
  pure_cost_ = mark.pure_cost;
  touched_ = mark.touched;
  removed_.resize(mark.removed);
  numbers_.roll_back(mark.numbers);
  ++epoch_;
}

void DiscreteHalf::start_epoch() noexcept {
  ++epoch_;
  added_.clear();
  removed_.clear();
  saved_tables_.clear();
  saved_values_.clear();
  base_.pure_cost = pure_cost_;
  base_.touched = touched_;
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
  saved_values_.emplace_back(key, assignment_.at(key));
  assignment_.set(key, value);
  for (int f : variables_.at(key).factors) refresh_cost(f);
}

void DiscreteHalf::list_changed(std::vector<Key>& keys) const {
  for (int f : added_) {
    for (const DiscreteKey& key : factors_[f].keys) keys.push_back(key.key);
  }
  for (const auto& [key, value] : saved_values_) keys.push_back(key);
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
  // An assignment lists its variables in no particular order.
  std::sort(report.flips.begin(), report.flips.end(),
            [](const Flip& a, const Flip& b) { return a.key < b.key; });
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
