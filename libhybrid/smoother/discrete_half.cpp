// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/discrete_half.h"

#include <algorithm>
#include <map>
#include <string>
#include <utility>

namespace hybrid {
namespace {

/// Variables of a component that is solved as a whole.
constexpr std::size_t kFew = 64;

}  // namespace

/// What is under way in `solve`.
struct DiscreteHalf::Pass {
  const DiscreteOptions& options;
  Report report;
  std::map<Key, int> former;                     // values of what has moved
  std::unordered_map<Key, bool> solved, listed;  // as a whole; to enter the tree
  std::vector<Key> entering;
};

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
      variable.number = variables_so_far_++;
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
    tree_.touch(key.key);
    if (!list.empty()) continue;
    tree_.forget(key.key);
    variables_.erase(it);
    assignment_.erase(key.key);
  }
  factors_[f] = {};
}

void DiscreteHalf::touch(Key key) {
  tree_.touch(key);
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
    Factor& factor = factors_[saved_tables_[i].first];
    factor.tables.swap(saved_tables_[i].second);
    for (const DiscreteKey& key : factor.keys) tree_.touch(key.key);
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

/// The common case of a variable that is alone in its component: a plain minimum. Nothing if it is
/// not alone.
std::optional<int> DiscreteHalf::best_single(Key key) const {
  const Variable& variable = variables_.at(key);
  std::vector<double> costs(variable.cardinality, 0.0);
  for (int f : variable.factors) {
    if (factors_[f].keys.size() != 1) return std::nullopt;
    for (const Table& table : factors_[f].tables) {
      for (std::size_t i = 0; i < costs.size(); ++i) costs[i] += table.costs()[i];
    }
  }
  const int incumbent = assignment_.at(key);
  const int best = static_cast<int>(std::min_element(costs.begin(), costs.end()) - costs.begin());
  return costs[best] < costs[incumbent] ? best : incumbent;
}

/// Whether the component of a variable has few others, none of which is in the tree.
bool DiscreteHalf::is_small(Key key) const {
  std::vector<Key> found = {key};
  std::unordered_map<Key, bool> seen = {{key, true}};
  for (std::size_t k = 0; k < found.size(); ++k) {
    if (found.size() > kFew || tree_.contains(found[k])) return false;
    for (int f : variables_.at(found[k]).factors) {
      for (const DiscreteKey& other : factors_[f].keys) {
        if (seen.emplace(other.key, true).second) found.push_back(other.key);
      }
    }
  }
  return true;
}

/// Lists a variable and all that are tied to it and not in the tree. Returns false where one of
/// them cannot be in it.
bool DiscreteHalf::enter_tree(Key key, Pass& pass) const {
  std::vector<Key>& out = pass.entering;
  const std::size_t before = out.size();
  bool fits = true;
  pass.listed[key] = true;
  out.push_back(key);
  for (std::size_t next = before; next < out.size(); ++next) {
    const Variable& variable = variables_.at(out[next]);
    fits = fits && !variable.is_wide;
    for (int f : variable.factors) {
      for (const DiscreteKey& other : factors_[f].keys) {
        if (tree_.contains(other.key)) continue;
        if (pass.listed.emplace(other.key, true).second) out.push_back(other.key);
      }
    }
  }
  if (!fits) out.resize(before);
  return fits;
}

void DiscreteHalf::set(Key key, int value, Pass& pass) {
  const int incumbent = assignment_.at(key);
  if (value == incumbent) return;
  pass.former.emplace(key, incumbent);
  move(key, value);
}

/// Solves a component without the tree.
void DiscreteHalf::solve_whole(Key key, Pass& pass) {
  const std::vector<const Table*> tables = collect(key, &pass.solved);
  const DiscreteSolution solution = solve_discrete(tables, pass.options, &assignment_);
  ++pass.report.components;
  pass.report.variables += static_cast<int>(solution.assignment.size());
  pass.report.exact = pass.report.exact && solution.exact;
  for (const auto& [variable, value] : solution.assignment) {
    set(variable, value, pass);
    tree_.forget(variable);
  }
}

/// Solves the component of a variable, or lists what is to enter the tree.
void DiscreteHalf::solve_touched(Key key, Pass& pass) {
  if (variables_.count(key) == 0 || pass.solved.count(key) != 0 || pass.listed.count(key) != 0) {
    return;
  }
  if (tree_.contains(key)) {
    tree_.touch(key);  // what was solved since may have been rolled back
    return;
  }
  if (const std::optional<int> best = best_single(key)) {
    pass.solved[key] = true;
    ++pass.report.components;
    ++pass.report.variables;
    set(key, *best, pass);
  } else if (is_small(key) || !enter_tree(key, pass)) {
    solve_whole(key, pass);
  }
}

void DiscreteHalf::solve_tree(Pass& pass) {
  const DiscreteTree::Source source{[this](Key key) { return variables_.at(key).number; },
                                    [this](Key key, std::vector<const Table*>& tables) {
                                      for (int f : variables_.at(key).factors) {
                                        for (const Table& table : factors_[f].tables) {
                                          const auto& keys = table.keys();
                                          const auto is_key = [&](const DiscreteKey& k) {
                                            return k.key == key;
                                          };
                                          if (std::any_of(keys.begin(), keys.end(), is_key))
                                            tables.push_back(&table);
                                        }
                                      }
                                    }};
  // Through the tree, some may belong to components that were solved as a whole after all.
  pass.entering.erase(std::remove_if(pass.entering.begin(), pass.entering.end(),
                                     [&](Key key) { return pass.solved.count(key) != 0; }),
                      pass.entering.end());
  DiscreteTree::Result tree = tree_.solve(pass.entering, source, assignment_);
  for (; !tree.wide.empty(); tree = tree_.solve({}, source, assignment_)) {
    for (const Key key : tree.wide) variables_.at(key).is_wide = true;
    for (const Key key : tree.wide) {
      if (tree_.contains(key)) solve_whole(key, pass);
    }
  }
  pass.report.components += tree.components;
  pass.report.variables += tree.made;
  for (const auto& [key, value] : tree.changed) set(key, value, pass);
}

DiscreteHalf::Report DiscreteHalf::solve(const DiscreteOptions& options) {
  Pass pass{options, {}, {}, {}, {}, {}};
  for (const Key key : touched_) solve_touched(key, pass);
  solve_tree(pass);
  for (const auto& [key, from] : pass.former) {
    if (assignment_.at(key) != from) pass.report.flips.push_back({key, from, assignment_.at(key)});
  }
  touched_.clear();
  return std::move(pass.report);
}

std::size_t DiscreteHalf::bytes() const {
  std::size_t bytes = factors_.capacity() * sizeof(Factor) +
                      variables_.size() * (sizeof(Key) + sizeof(Variable) + 2 * sizeof(void*)) +
                      tree_.bytes();
  for (const Factor& factor : factors_) {
    for (const Table& table : factor.tables) {
      bytes += sizeof(Table) + table.costs().capacity() * sizeof(double) +
               table.keys().capacity() * sizeof(DiscreteKey);
    }
  }
  return bytes;
}

}  // namespace hybrid
