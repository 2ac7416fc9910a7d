// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/window_tables.h"

#include <algorithm>

namespace hybrid {
namespace {

/// Sum of two tables over one and the same variable; an empty one counts as zero.
Table sum(const Table& a, const Table& b) {
  if (a.keys().empty()) return b;
  std::vector<double> costs = a.costs();
  for (std::size_t i = 0; i < costs.size(); ++i) costs[i] += b.costs()[i];
  return {a.keys(), std::move(costs)};
}

}  // namespace

void add_constant(double constant, Delta& change) {
  for (Table& table : change.discrete) {
    if (table.keys().empty()) table = Table({}, {table.costs()[0] + constant});
  }
}

void WindowTables::enter(const AddedHandles& added, const HybridGraph& graph) {
  const auto enter_all = [&](const std::vector<DiscreteKey>& keys, Handle handle) {
    for (const DiscreteKey& key : keys) enter(key.key, handle);
  };
  for (Handle handle : added.discrete) enter_all(graph.discrete().at(handle).keys(), handle);
  for (Handle handle : added.hybrid) enter_all(graph.hybrid().at(handle)->discrete_keys(), handle);
}

void WindowTables::forget(Key key) {
  holders_.erase(key);
  own_.erase(key);
}

void WindowTables::take(const std::vector<Handle>& tables, const HybridGraph& graph) {
  for (Handle handle : tables) {
    const Table& table = graph.discrete().at(handle);
    if (table.keys().empty()) constant_ = handle;
    for (const DiscreteKey& key : table.keys()) holders_[key.key].push_back(handle);
    if (table.keys().size() == 1) own_[table.keys()[0].key] = handle;
  }
}

bool WindowTables::is_tied(Key key, const HybridGraph& graph,
                           const std::vector<Handle>& going) const {
  const auto it = holders_.find(key);
  if (it == holders_.end()) return false;
  return std::any_of(it->second.begin(), it->second.end(), [&](Handle handle) {
    return handle.kind == FactorKind::kDiscrete && graph.contains(handle) &&
           graph.discrete().at(handle).keys().size() > 1 &&
           std::find(going.begin(), going.end(), handle) == going.end();
  });
}

std::vector<Key> WindowTables::chosen_by(const std::vector<Handle>& factors,
                                         const HybridGraph& graph,
                                         const std::vector<Key>& discrete) const {
  std::vector<Key> chosen;
  for (Key key : discrete) {
    bool chooses = false, stays = false;
    for (Handle handle : holders_.at(key)) {
      if (handle.kind != FactorKind::kHybrid || !graph.contains(handle)) continue;
      stays = stays || std::find(factors.begin(), factors.end(), handle) == factors.end();
      const auto selectors = graph.hybrid().at(handle)->selectors();
      chooses = chooses || std::any_of(selectors.begin(), selectors.end(),
                                       [&](const DiscreteKey& own) { return own.key == key; });
    }
    if (chooses && !stays) chosen.push_back(key);
  }
  return chosen;
}

std::optional<Table> WindowTables::settle(Key key, const HybridGraph& graph, Delta& change) {
  std::vector<Handle>& holders = holders_[key];
  const auto dead = [&](Handle handle) { return !graph.contains(handle); };
  holders.erase(std::remove_if(holders.begin(), holders.end(), dead), holders.end());
  std::vector<Handle> staying;
  for (Handle handle : holders) {
    if (std::find(change.remove.begin(), change.remove.end(), handle) == change.remove.end())
      staying.push_back(handle);
  }
  const auto its_own = [&](const Table& table) {
    return table.keys().size() == 1 && table.keys()[0].key == key;
  };
  const auto holds = [&](const Table& table) {
    return std::any_of(table.keys().begin(), table.keys().end(),
                       [&](const DiscreteKey& other) { return other.key == key; });
  };
  const bool leaves = std::all_of(staying.begin(), staying.end(),
                                  [&](Handle handle) {
                                    return handle.kind == FactorKind::kDiscrete &&
                                           its_own(graph.discrete().at(handle));
                                  }) &&
                      std::none_of(change.discrete.begin(), change.discrete.end(),
                                   [&](const Table& t) { return holds(t) && !its_own(t); });
  const auto added = std::find_if(change.discrete.begin(), change.discrete.end(), its_own);
  if (!leaves) {
    const auto before = own_.find(key);
    if (added == change.discrete.end() || before == own_.end()) return std::nullopt;
    *added = sum(*added, graph.discrete().at(before->second));
    change.remove.push_back(before->second);
    return std::nullopt;
  }
  Table total;
  if (added != change.discrete.end()) {
    total = *added;
    change.discrete.erase(added);
  }
  for (Handle handle : staying) {
    total = sum(total, graph.discrete().at(handle));
    change.remove.push_back(handle);
  }
  return total;
}

void WindowTables::settle_constant(const HybridGraph& graph, const Assignment& assignment,
                                   std::vector<std::pair<Key, Table>>& settled,
                                   Delta& change) const {
  double constant = 0.0;
  for (auto& [key, table] : settled) {
    if (table.keys().empty()) continue;
    const double last = table.cost(assignment);
    std::vector<double> costs = table.costs();
    for (double& cost : costs) cost -= last;
    table = Table(table.keys(), std::move(costs));
    constant += last;
  }
  if (constant_) {
    constant += graph.discrete().at(*constant_).costs()[0];
    change.remove.push_back(*constant_);
  }
  add_constant(constant, change);
}

}  // namespace hybrid
