// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/discrete/junction_forest.h"

namespace hybrid {

/// Relates a table to a smaller one over some of its variables: the cardinalities of the table's
/// variables, and for each the step in the smaller table (0 if that does not depend on it).
struct Strides {
  std::vector<int> dims;
  std::vector<std::size_t> steps;
};

/// Exact inference on the cliques of a junction forest, in the domain of costs -log f.
class VariableElimination {
 public:
  VariableElimination(const DiscreteGraph& graph, const JunctionForest& forest);

  /// Max-product: replaces `values` (by variable id; -1 for unknown) of all variables in the forest
  /// by the joint values of least cost. Ties go to the value given, then to the smallest.
  void minimize(std::vector<int>& values);

  /// Sum-product, leaves to roots and back: afterwards every clique holds its normalised belief.
  /// Returns log sum exp(-cost); stops at the first impossible clique.
  double calibrate();

  /// The variables (ids) of each clique found to have no possible joint value.
  const std::vector<std::vector<int>>& impossible() const { return impossible_; }

  /// Probabilities of some variables that share a clique, row-major in the order given. Valid after
  /// a `calibrate` that found nothing impossible.
  std::vector<double> marginal(const std::vector<int>& variables);

 private:
  void list_tables();
  void adopt(int p);
  void load_scope(int p);
  void fill_clique(int p, double* table);
  void add(const double* source, double* table, std::size_t size);
  void minimize_clique(int p, const double* table, int incumbent);
  void sum_clique(int p, const double* table);
  void strides_of_table(int t);
  void strides_of_separator(int p);
  void sum_onto(const double* table, std::size_t size, std::vector<double>& out);
  void distribute(int p);
  bool normalize_message(int p);
  int dim(int p) const { return graph_.cardinality(forest_.order[p]); }

  const DiscreteGraph& graph_;
  const JunctionForest& forest_;
  std::vector<int> first_table_, next_table_;  // linked lists by position and by table
  std::vector<int> first_child_, next_child_;  // linked lists by position
  std::vector<std::size_t> message_begin_;     // by position
  std::vector<double> messages_;               // clique -> parent, over the separator, minimum 0
  std::vector<double> offset_;                 // the minimum subtracted from each message
  std::vector<int> choices_;                   // best value, laid out like the messages
  std::vector<std::size_t> clique_begin_;
  std::vector<double> cliques_;
  std::vector<std::vector<int>> impossible_;

  std::vector<int> scope_;  // of the current clique: separator, then its own variable
  Strides strides_;
  std::vector<int> counter_;
  std::vector<double> scratch_;
};

}  // namespace hybrid
