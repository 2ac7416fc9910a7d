// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/discrete/graph.h"

namespace HYBRID_API hybrid {

/// Limits on the memory of exact inference, in table entries (doubles).
struct TableLimits {
  std::size_t max_table = std::size_t{1} << 22;  ///< any one intermediate table
  std::size_t max_total = std::size_t{1} << 27;  ///< all intermediate tables together
};

/// A component that cannot be eliminated within the limits: the next table if the component does
/// not fit even alone, else all its tables, which do not fit beside those of smaller components.
struct TooLarge {
  int component = 0;
  std::vector<int> variables;  ///< of that table or those tables
  double entries = 0.0;        ///< of that table or those tables
};

/// The order in which variables are eliminated, and the clique each elimination forms. A variable
/// is named by its position in that order. Cliques form a forest: the parent of a clique is that of
/// the first variable of its separator to be eliminated.
struct JunctionForest {
  std::vector<int> order;            ///< variable id by position
  std::vector<int> position;         ///< by variable id; -1 if not eliminated
  std::vector<std::size_t> entries;  ///< of the clique table, by position
  std::vector<int> separator_begin;  ///< by position, and one past the last
  std::vector<int> separators;       ///< positions, descending within a clique
  std::vector<TooLarge> too_large;

  int size() const { return static_cast<int>(order.size()); }
  /// A clique without its own variable.
  IntSpan separator(int p) const {
    return {separators.data() + separator_begin[p], separators.data() + separator_begin[p + 1]};
  }
  /// -1 for a root.
  int parent(int p) const {
    return separator_begin[p] == separator_begin[p + 1] ? -1
                                                        : separators[separator_begin[p + 1] - 1];
  }
};

/// Orders the components of two or more variables (of any size if `with_singles`): leaves first,
/// then the fewest added edges, then the smallest table, then the smallest id.
JunctionForest make_junction_forest(const DiscreteGraph& graph, const TableLimits& limits,
                                    bool with_singles);

}  // namespace hybrid
