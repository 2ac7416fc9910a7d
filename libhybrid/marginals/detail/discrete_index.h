// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <unordered_map>
#include <vector>

#include "libhybrid/hybrid/graph.h"

namespace hybrid {

/// The factors of a graph by discrete variable. The graph must outlive it unchanged.
class DiscreteIndex {
 public:
  explicit DiscreteIndex(const HybridGraph& graph);

  struct Variable {
    DiscreteKey key;
    bool selects = false;  ///< whether it chooses the component of some hybrid factor
    std::vector<const Table*> tables;
    std::vector<const HybridFactor*> factors;
  };
  /// Throws Error for a variable in no factor.
  const Variable& at(Key key) const;
  /// The variables of `start`, then all that share tables or hybrid factors with them, directly or
  /// through others; `through` must accept every variable that is added.
  template <class Through>
  std::vector<Key> connected(const std::vector<Key>& start, const Through& through) const;

 private:
  Variable& entry(DiscreteKey key);

  std::unordered_map<Key, Variable> variables_;
};

template <class Through>
std::vector<Key> DiscreteIndex::connected(const std::vector<Key>& start,
                                          const Through& through) const {
  std::vector<Key> found = start;
  std::unordered_map<Key, bool> seen;
  for (Key key : start) seen[key] = true;
  const auto visit = [&](const std::vector<DiscreteKey>& keys) {
    for (const DiscreteKey& other : keys) {
      if (through(other.key) && seen.emplace(other.key, true).second) found.push_back(other.key);
    }
  };
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Variable& variable = at(found[i]);
    for (const Table* table : variable.tables) visit(table->keys());
    for (const HybridFactor* factor : variable.factors) visit(factor->discrete_keys());
  }
  return found;
}

}  // namespace hybrid
