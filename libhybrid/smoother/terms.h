// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <array>
#include <vector>

#include "libhybrid/core/journal.h"
#include "libhybrid/core/values.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/linear/bayes_tree.h"
#include "libhybrid/linear/free_list.h"

namespace HYBRID_API hybrid {

/// Multiplications in the time that it takes to evaluate or linearise a term, about.
inline constexpr double kWorkOfTerm = 500.0;

/// What a component adds to the objective beside its cost.
inline double constant_of(const Component& component) {
  return component.constant + (component.factor ? component.factor->log_normalizer() : 0.0);
}

/// What changes of a term while it is in the graph.
struct TermState {
  Component component;    ///< of a continuous factor: itself
  double constant = 0.0;  ///< constant_of(component)
  int tree_factor = -1;   ///< number in the Bayes tree; -1 while left out of it, as weak ones are
  /// Of a weak component: for each of its variables a factor with its gradient, so that it pulls
  /// without tying variables together. Entered only when the smoother converges.
  std::vector<int> pulls;
  double cost = 0.0;  ///< -log f at the estimate, normaliser included
  /// What a robust loss adds, at the linearisation point, to half the squared residual of its
  /// linear model; zero without one.
  double model_offset = 0.0;
  double model_error = 0.0;  ///< by which its cost exceeds that of its linear model
  bool alive = false;
};

/// One factor as the smoother keeps it: a continuous factor, or a hybrid factor with its chosen
/// component.
struct Term : TermState {
  bool holds = false;  ///< its variables in the map: it changes where the map moves
  int table = -1;      ///< of a hybrid factor: its number in the discrete half
  unsigned saved = 0;  ///< epoch of Terms in which it was last saved
  Handle handle;
  ContinuousFactorPtr continuous;  ///< null for a hybrid factor
  HybridFactorPtr hybrid;          ///< null for a continuous factor
  std::vector<int> slots;          ///< of keys(), in the values

  void choose(const Component& chosen) {
    component = chosen;
    constant = constant_of(chosen);
  }
  const std::vector<Key>& keys() const { return hybrid ? hybrid->keys() : continuous->keys(); }
};

/// Pointers to the variables of the active component, on the stack where they are few.
class TermPointers {
 public:
  TermPointers(const Term& term, const Values& values) {
    const std::size_t n = term.component.factor->keys().size();
    if (n > kFew) many_.resize(n);
    const double** x = n > kFew ? many_.data() : few_.data();
    for (std::size_t i = 0; i < n; ++i) {
      const int position =
          term.component.positions ? term.component.positions[i] : static_cast<int>(i);
      x[i] = values.data(term.slots[position]);
    }
  }
  const double* const* data() const { return many_.empty() ? few_.data() : many_.data(); }

 private:
  static constexpr std::size_t kFew = 8;
  std::array<const double*, kFew> few_;
  std::vector<const double*> many_;
};

/// -log of the term at the given values, normaliser included.
double evaluate(const Term& term, const Values& values);

/// Writes the Hessian of the active component at `values` into the tree, where the term is part of
/// it, with these values as notes, and notes the offset of the linear model.
void linearize(Term& term, const Values& values, BayesTree& tree);

/// How many numbers the variables of a factor are.
int point_size(const ContinuousFactor& factor);

/// Slots of the variables of the active component, in its own order.
std::vector<int> active_slots(const Term& term);

/// The terms of a graph and, for every variable, those that hold it. What happened since the last
/// `commit`, or since a mark after it, can be rolled back; terms that are removed are no longer
/// alive, and go with the commit.
class Terms {
 public:
  /// Returns the number of the new term.
  int add(Term term);
  void remove(int t);
  /// Makes of_variable(slot) valid.
  void reserve_variable(int slot) {
    if (slot >= static_cast<int>(adjacency_.size())) adjacency_.resize(slot + 1);
  }

  const Term& operator[](int t) const { return terms_[t]; }
  /// A term to be changed in its component, its place in the tree or its cost.
  Term& edit(int t) {
    Term& term = terms_[t];
    saved_.save(t, term.saved, &term);
    return term;
  }
  void prefetch(int t) const;
  int count() const { return static_cast<int>(terms_.size()); }
  const std::vector<int>& of_variable(int slot) const { return adjacency_[slot]; }
  std::size_t bytes() const;

  void commit() noexcept;
  struct Mark {
    std::size_t added = 0, removed = 0, saved = 0, numbers = 0;
  };
  Mark mark() { return {added_.size(), removed_.size(), saved_.mark(), numbers_.mark()}; }
  void roll_back(const Mark& mark) noexcept;

 private:
  void take_out(int t);

  std::vector<Term> terms_;
  FreeList numbers_;
  std::vector<std::vector<int>> adjacency_;
  std::vector<int> added_, removed_;
  Journal<TermState> saved_;
};

}  // namespace hybrid
