// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "libhybrid/hybrid/graph.h"

namespace HYBRID_API hybrid {

/// Adds to the table over no variable, of which a change has one.
void add_constant(double constant, Delta& change);

/// The factors of a window by discrete variable, and the tables in which departures gather what
/// they leave.
class WindowTables {
 public:
  void enter(const AddedHandles& added, const HybridGraph& graph);
  void enter(Key key, Handle table) { holders_[key].push_back(table); }
  /// Forgets a variable that has left.
  void forget(Key key);
  /// Remembers the tables that marginalisation has left.
  void take(const std::vector<Handle>& tables, const HybridGraph& graph);

  /// Factors that hold a variable; some may be gone.
  const std::vector<Handle>& holders(Key key) const { return holders_.at(key); }
  /// Whether a discrete variable shares a table with others, beside the factors that go.
  bool is_tied(Key key, const HybridGraph& graph, const std::vector<Handle>& going) const;
  /// Those of some discrete variables that chose the components of factors which all go.
  std::vector<Key> chosen_by(const std::vector<Handle>& factors, const HybridGraph& graph,
                             const std::vector<Key>& discrete) const;

  /// A discrete variable that a change leaves with nothing but tables of its own goes too: the
  /// change then removes them, and their sum is returned (empty without tables). Of a variable that
  /// stays, the table that the change adds takes in the one of earlier changes, so that their
  /// number does not grow.
  std::optional<Table> settle(Key key, const HybridGraph& graph, Delta& change);
  /// Gathers what the objective keeps of all that has left in one table over no variable: that of
  /// the change, that of earlier changes, and the last costs of discrete variables that leave.
  void settle_constant(const HybridGraph& graph, const Assignment& assignment,
                       std::vector<std::pair<Key, Table>>& settled, Delta& change) const;

 private:
  std::unordered_map<Key, std::vector<Handle>> holders_;
  std::unordered_map<Key, Handle> own_;  // single-variable tables that marginalisation left
  std::optional<Handle> constant_;       // and the table over no variable
};

}  // namespace hybrid
