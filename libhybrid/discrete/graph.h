// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/core/assignment.h"
#include "libhybrid/core/key.h"
#include "libhybrid/discrete/table.h"

namespace HYBRID_API hybrid {

/// A contiguous range of an array of integers.
struct IntSpan {
  const int* first = nullptr;
  const int* last = nullptr;

  const int* begin() const { return first; }
  const int* end() const { return last; }
  int size() const { return static_cast<int>(last - first); }
  int operator[](int i) const { return first[i]; }
};

/// Tables indexed for inference: variables become the ids 0, 1, ... in order of first appearance,
/// and are split into connected components. Holds pointers: the tables must outlive it.
class DiscreteGraph {
 public:
  /// Throws Error if two tables disagree about a cardinality.
  explicit DiscreteGraph(std::vector<const Table*> tables);

  const std::vector<const Table*>& tables() const { return tables_; }
  const std::vector<DiscreteKey>& variables() const { return variables_; }
  int cardinality(int variable) const { return variables_[variable].cardinality; }
  int size() const { return static_cast<int>(variables_.size()); }

  /// Variables of a table, in its order.
  IntSpan scope(int table) const {
    return {scope_.data() + scope_begin_[table], scope_.data() + scope_begin_[table + 1]};
  }

  /// Components are numbered by their first variable. A table without variables is in none.
  int component_count() const { return static_cast<int>(variables_begin_.size()) - 1; }
  int component(int variable) const { return component_[variable]; }
  IntSpan component_variables(int component) const {
    return {by_component_.data() + variables_begin_[component],
            by_component_.data() + variables_begin_[component + 1]};
  }
  IntSpan component_tables(int component) const {
    return {tables_by_component_.data() + tables_begin_[component],
            tables_by_component_.data() + tables_begin_[component + 1]};
  }

  /// Cost of one table at values by variable id.
  double cost(int table, const std::vector<int>& values) const;

 private:
  void index_variables();
  void split_components();

  std::vector<const Table*> tables_;
  std::vector<DiscreteKey> variables_;
  std::vector<int> scope_begin_;
  std::vector<int> scope_;
  std::vector<int> component_;
  std::vector<int> variables_begin_;
  std::vector<int> by_component_;
  std::vector<int> tables_begin_;
  std::vector<int> tables_by_component_;
};

/// The tables of every connected component, as indices into `tables`; tables without variables are
/// left out.
std::vector<std::vector<int>> connected_components(const std::vector<const Table*>& tables);

}  // namespace hybrid
