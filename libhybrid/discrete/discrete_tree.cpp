// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/discrete/discrete_tree.h"

#include <algorithm>

#include "libhybrid/core/infinity.h"

namespace hybrid {
namespace {

constexpr std::size_t kMostCosts = 4096;  // of a message with the variable that sends it

/// Adds costs over some variables of a scope.
void add_costs(const std::vector<DiscreteKey>& scope, std::vector<double>& sum,
               const std::vector<DiscreteKey>& keys, const std::vector<double>& costs) {
  std::vector<std::size_t> strides(scope.size(), 0);
  std::size_t stride = 1;
  for (std::size_t k = keys.size(); k-- > 0;) {
    for (std::size_t i = 0; i < scope.size(); ++i) {
      if (scope[i].key == keys[k].key) strides[i] = stride;
    }
    stride *= static_cast<std::size_t>(keys[k].cardinality);
  }
  std::vector<int> digits(scope.size(), 0);
  std::size_t at = 0;
  for (double& cost : sum) {
    cost += costs[at];
    for (std::size_t i = scope.size(); i-- > 0;) {
      at += strides[i];
      if (++digits[i] < scope[i].cardinality) break;
      at -= strides[i] * static_cast<std::size_t>(digits[i]);
      digits[i] = 0;
    }
  }
}

/// The least of each row: costs of all but the last variable.
std::vector<double> least_of_rows(const std::vector<double>& costs, int columns) {
  std::vector<double> out;
  for (auto row = costs.begin(); row != costs.end(); row += columns) {
    out.push_back(*std::min_element(row, row + columns));
  }
  return out;
}

}  // namespace

std::optional<Key> DiscreteTree::parent_of(const Node& node) const {
  if (node.scope.size() < 2) return std::nullopt;
  return node.scope.front().key;
}

void DiscreteTree::touch(Key key) noexcept {
  const auto it = nodes_.find(key);
  if (it == nodes_.end() || it->second.is_touched) return;
  it->second.is_touched = true;
  touched_.push_back(key);
}

void DiscreteTree::detach(Key key, const Node& node) noexcept {
  const auto parent = parent_of(node);
  const auto it = parent ? nodes_.find(*parent) : nodes_.end();
  if (it == nodes_.end()) return;
  std::vector<Key>& siblings = it->second.children;
  siblings.erase(std::remove(siblings.begin(), siblings.end(), key), siblings.end());
}

void DiscreteTree::forget(Key key) noexcept {
  const auto it = nodes_.find(key);
  if (it == nodes_.end()) return;
  detach(key, it->second);
  if (const auto parent = parent_of(it->second)) touch(*parent);
  for (const Key child : it->second.children) touch(child);
  nodes_.erase(it);
}

/// The tables of a variable that belong to it: of a table, the oldest variable is the owner.
std::vector<const Table*> DiscreteTree::own_tables(Key key, const Node& node,
                                                   const Source& source) {
  std::vector<const Table*> tables;
  source.tables(key, tables);
  const auto is_older = [&](const DiscreteKey& k) {
    return k.key != key && source.number(k.key) < node.number;
  };
  const auto is_foreign = [&](const Table* table) {
    return std::any_of(table->keys().begin(), table->keys().end(), is_older);
  };
  tables.erase(std::remove_if(tables.begin(), tables.end(), is_foreign), tables.end());
  return tables;
}

/// Sets the scope of a variable. Returns false where its costs would be too many.
bool DiscreteTree::set_scope(Key key, Node& node, const std::vector<const Table*>& tables,
                             const Source& source) const {
  std::map<std::uint64_t, DiscreteKey> others;
  DiscreteKey own{key, 0};
  const auto note = [&](const DiscreteKey& k) {
    if (k.key == key) {
      own = k;
    } else {
      others.emplace(source.number(k.key), k);
    }
  };
  for (const Table* table : tables) {
    for (const DiscreteKey& k : table->keys()) note(k);
  }
  for (const Key child : node.children) {
    const std::vector<DiscreteKey>& scope = nodes_.at(child).scope;
    std::for_each(scope.begin(), scope.end() - 1, note);
  }
  node.scope.clear();
  auto size = static_cast<std::size_t>(own.cardinality);
  for (const auto& [number, k] : others) {
    size *= static_cast<std::size_t>(k.cardinality);
    if (size > kMostCosts) {
      node.scope.clear();
      return false;
    }
    node.scope.push_back(k);
  }
  node.scope.push_back(own);
  node.costs.assign(size, 0.0);
  return true;
}

/// Makes the costs of a variable together with what its message depends on. Returns false where
/// these are too many.
bool DiscreteTree::make(Key key, Node& node, const Source& source) const {
  const std::vector<const Table*> tables = own_tables(key, node, source);
  if (!set_scope(key, node, tables, source)) return false;
  for (const Table* table : tables) {
    add_costs(node.scope, node.costs, table->keys(), table->costs());
  }
  for (const Key child : node.children) {
    const Node& sender = nodes_.at(child);
    const std::vector<DiscreteKey> keys(sender.scope.begin(), sender.scope.end() - 1);
    add_costs(node.scope, node.costs, keys,
              least_of_rows(sender.costs, sender.scope.back().cardinality));
  }
  return true;
}

void DiscreteTree::attach(Key key, const Node& node, std::set<Numbered>& waiting) {
  const auto parent = parent_of(node);
  if (!parent) return;
  Node& receiver = nodes_.at(*parent);
  receiver.children.push_back(key);
  waiting.emplace(receiver.number, *parent);
}

/// Makes all messages again that depend on what was touched, the oldest first.
std::vector<Key> DiscreteTree::make_all(const std::vector<Key>& entering, const Source& source,
                                        std::vector<Key>& wide) {
  std::set<Numbered> waiting;
  for (const Key key : entering) {
    Node& node = nodes_[key];
    node.number = source.number(key);
    waiting.emplace(node.number, key);
  }
  for (const Key key : touched_) {
    const auto it = nodes_.find(key);
    if (it == nodes_.end()) continue;
    it->second.is_touched = false;
    waiting.emplace(it->second.number, key);
  }
  touched_.clear();
  touched_.reserve(nodes_.size());
  std::vector<Key> made;
  while (!waiting.empty()) {
    const Numbered next = *waiting.begin();
    waiting.erase(waiting.begin());
    Node& node = nodes_.at(next.second);
    const auto parent = parent_of(node);
    if (const auto it = parent ? nodes_.find(*parent) : nodes_.end(); it != nodes_.end()) {
      waiting.emplace(it->second.number, *parent);
      detach(next.second, node);
    }
    made.push_back(next.second);
    if (make(next.second, node, source)) {
      attach(next.second, node, waiting);
    } else {
      wide.push_back(next.second);
    }
  }
  return made;
}

/// The costs of the values of a variable, given those that its message depends on.
std::vector<double>::const_iterator DiscreteTree::costs_given(
    const Node& node, const std::function<int(Key)>& value_of) {
  std::size_t row = 0;
  for (std::size_t i = 0; i + 1 < node.scope.size(); ++i) {
    row = row * static_cast<std::size_t>(node.scope[i].cardinality) +
          static_cast<std::size_t>(value_of(node.scope[i].key));
  }
  return node.costs.begin() + static_cast<std::ptrdiff_t>(row) * node.scope.back().cardinality;
}

/// Values of a tree that change, from its root, which comes first, downwards: where they or what
/// they depend on were made again.
std::map<Key, int> DiscreteTree::descend(const std::vector<Key>& made,
                                         const Assignment& incumbent) const {
  std::map<Key, int> changed;
  const auto value_of = [&](Key key) {
    const auto it = changed.find(key);
    return it != changed.end() ? it->second : incumbent.at(key);
  };
  std::set<Numbered, std::greater<>> waiting;
  for (const Key key : made) waiting.emplace(nodes_.at(key).number, key);
  while (!waiting.empty()) {
    const Key key = waiting.begin()->second;
    waiting.erase(waiting.begin());
    const Node& node = nodes_.at(key);
    const auto costs = costs_given(node, value_of);
    const auto best = std::min_element(costs, costs + node.scope.back().cardinality);
    if (key == made.front() && *best == kInfinity) return {};
    if (*best < costs[incumbent.at(key)]) changed[key] = static_cast<int>(best - costs);
    for (const Key child : node.children) {
      const Node& below = nodes_.at(child);
      const bool depends =
          std::any_of(below.scope.begin(), below.scope.end() - 1,
                      [&](const DiscreteKey& k) { return changed.count(k.key) != 0; });
      if (depends) waiting.emplace(below.number, child);
    }
  }
  return changed;
}

/// Whether changed values cost less: rounding may call one of two equal assignments the better one.
bool DiscreteTree::cost_less(const std::map<Key, int>& changed, const Source& source,
                             const Assignment& incumbent) {
  std::vector<const Table*> tables;
  for (const auto& [key, value] : changed) source.tables(key, tables);
  std::set<const Table*> seen;
  Assignment next;
  double before = 0, after = 0;
  for (const Table* table : tables) {
    if (!seen.insert(table).second) continue;
    for (const DiscreteKey& k : table->keys()) {
      const auto it = changed.find(k.key);
      next.set(k.key, it != changed.end() ? it->second : incumbent.at(k.key));
    }
    before += table->cost(incumbent);
    after += table->cost(next);
  }
  return after < before;
}

DiscreteTree::Result DiscreteTree::solve(const std::vector<Key>& entering, const Source& source,
                                         const Assignment& incumbent) try {
  Result result;
  const std::vector<Key> made = make_all(entering, source, result.wide);
  result.made = static_cast<int>(made.size());
  if (!result.wide.empty()) {
    for (const Key key : made) touch(key);
    return result;
  }
  // All ways lead to a root, which was made last.
  std::unordered_map<Key, Key> root_of;
  std::map<std::uint64_t, std::vector<Key>> by_root;
  for (auto it = made.rbegin(); it != made.rend(); ++it) {
    const auto parent = parent_of(nodes_.at(*it));
    const Key root = parent ? root_of.at(*parent) : *it;
    root_of.emplace(*it, root);
    by_root[nodes_.at(root).number].push_back(*it);
  }
  result.components = static_cast<int>(by_root.size());
  for (const auto& [number, keys] : by_root) {
    const std::map<Key, int> changed = descend(keys, incumbent);
    if (!cost_less(changed, source, incumbent)) continue;
    result.changed.insert(result.changed.end(), changed.begin(), changed.end());
  }
  return result;
} catch (...) {
  nodes_.clear();  // it holds nothing that cannot be made again
  touched_.clear();
  throw;
}

std::size_t DiscreteTree::bytes() const {
  std::size_t bytes = nodes_.size() * (sizeof(Key) + sizeof(Node) + 2 * sizeof(void*));
  for (const auto& [key, node] : nodes_) {
    bytes += node.scope.capacity() * sizeof(DiscreteKey) + node.costs.capacity() * sizeof(double) +
             node.children.capacity() * sizeof(Key);
  }
  return bytes;
}

}  // namespace hybrid
