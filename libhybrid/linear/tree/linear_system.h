// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <new>
#include <utility>
#include <vector>

#include "libhybrid/core/journal.h"
#include "libhybrid/export.h"
#include "libhybrid/linear/block.h"
#include "libhybrid/linear/free_list.h"

namespace HYBRID_API hybrid {

/// Entries of the lower triangle of a symmetric matrix of order n, packed column by column.
inline std::size_t packed_size(std::size_t n) {
  return n * (n + 1) / 2;
}

/// Column c of such a triangle, as a pointer to its entries by row, from the diagonal on.
template <class T>
T* packed_column(T* triangle, std::size_t n, std::size_t c) {
  return triangle + (c * n - c * (c + 1) / 2);
}

/// Short arrays of doubles in large blocks of memory, by number; freed arrays are reused by others
/// of the same length. Numbers and pointers stay valid when the pool grows.
class Pool {
 public:
  std::size_t allocate(std::size_t length) {
    if (length < free_.size() && !free_[length].empty()) {
      const std::size_t number = free_[length].back();
      free_[length].pop_back();
      return number;
    }
    if (blocks_.empty() || used_ + length > kBlock) {  // a longer array has a block of its own
      blocks_.emplace_back(length < kBlock ? kBlock : length);
      bytes_ += blocks_.back().bytes();
      used_ = 0;
    }
    const std::size_t number = (blocks_.size() - 1) * kBlock + used_;
    used_ += length;
    return number;
  }
  /// Frees an array for reuse; without memory for that, its place is never used again.
  void release(std::size_t number, std::size_t length) noexcept {
    try {
      if (length >= free_.size()) free_.resize(length + 1);
      free_[length].push_back(number);
    } catch (const std::bad_alloc&) {  // NOLINT(bugprone-empty-catch)
    }
  }

  double* at(std::size_t number) { return blocks_[number / kBlock].data() + number % kBlock; }
  const double* at(std::size_t number) const {
    return blocks_[number / kBlock].data() + number % kBlock;
  }
  std::size_t bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kBlock = 4096;

  std::vector<Block> blocks_;
  std::size_t used_ = 0;  // of the last block
  std::size_t bytes_ = 0;
  std::vector<std::vector<std::size_t>> free_;
};

/// What a Bayes tree solves: the factors of min ||J d + r||^2 as Hessians, the variables with their
/// steps d, and the cliques of the tree that they touch.
class LinearSystem {
 public:
  static constexpr int kPending = -2;
  struct Factor {
    std::vector<int> variables;
    int order = 0;   ///< of the Hessian
    int points = 0;  ///< numbers behind it
    std::size_t hessian = 0;
    int clique = -1;  ///< in which it is assembled; kPending where its rows are in no clique yet
    bool alive = false;
    unsigned saved = 0;  ///< epoch in which its Hessian was last saved
    std::size_t size() const { return packed_size(order) + points; }
  };
  /// What came or went since the last commit; from `uneliminated` on it is not eliminated yet.
  struct Changes {
    std::vector<int> all;
    std::size_t uneliminated = 0;
    auto begin() const { return all.begin() + static_cast<std::ptrdiff_t>(uneliminated); }
    auto end() const { return all.end(); }
  };
  enum Change { kNewVariables, kRemovedVariables, kNewFactors, kRemovedFactors, kChanges };

  void add_variable(int v, int dim);
  void remove_variable(int v) {
    touch_variable(v);
    changes_[kRemovedVariables].all.push_back(v);
  }
  int add_factor(const std::vector<int>& variables, int points);
  void remove_factor(int f) {
    touch_factor(f);
    changes_[kRemovedFactors].all.push_back(f);
    factors_[f].alive = false;
  }
  const Changes& changes(Change kind) const { return changes_[kind]; }
  /// Cliques to be eliminated again.
  const std::vector<int>& touched() const { return touched_; }
  void touch(int clique) {
    if (clique >= 0) touched_.push_back(clique);
    if (clique == kPending) touches_pending_ = true;
  }
  /// Whether all that has changed is that variables and factors have come.
  bool only_grows() const {
    const auto none = [&](Change kind) { return changes_[kind].begin() == changes_[kind].end(); };
    return touched_.empty() && !touches_pending_ && none(kRemovedVariables) &&
           none(kRemovedFactors);
  }
  void touch_variable(int v) { touch(variables_[v].clique); }
  void touch_factor(int f) { touch(factors_[f].clique); }
  /// Nothing is to be eliminated or touched any more.
  void note_eliminated() {
    for (Changes& changes : changes_) changes.uneliminated = changes.all.size();
    touched_.clear();
    touches_pending_ = false;
  }

  /// Variables have numbers below this.
  int variable_count() const { return static_cast<int>(variables_.size()); }
  int dim(int v) const { return variables_[v].dim; }
  /// The clique that eliminates a variable; -1 if there is none yet.
  int clique_of(int v) const { return variables_[v].clique; }
  void set_clique(int v, int clique) { variables_[v].clique = clique; }
  const double* delta(int v) const { return deltas_.at(variables_[v].delta); }
  double* edit_delta(int v) {
    Variable& variable = variables_[v];
    double* delta = deltas_.at(variable.delta);
    saved_deltas_.save(v, variable.saved, delta, variable.dim);
    return delta;
  }
  /// Copies the steps of variables from one number to another of a list; returns the end.
  double* copy_deltas(const std::vector<int>& list, std::size_t from, std::size_t to,
                      double* out) const {
    for (; from < to; ++from) out = std::copy_n(delta(list[from]), dim(list[from]), out);
    return out;
  }
  /// Lists a variable, once, among those that a solution has moved.
  void note_moved(int v) {
    if (!variables_[v].moved) moved_.push_back(v);
    variables_[v].moved = true;
  }
  std::vector<int> take_moved() noexcept {
    for (int v : moved_) variables_[v].moved = false;
    return std::exchange(moved_, {});
  }

  const Factor& factor(int f) const { return factors_[f]; }
  void set_factor_clique(int f, int clique) { factors_[f].clique = clique; }
  /// The augmented Hessian [J r]'[J r] of a factor, packed lower triangle, and the points behind.
  const double* hessian(int f) const { return hessians_.at(factors_[f].hessian); }
  /// The same for writing; touches the factor.
  double* edit_hessian(int f) {
    touch_factor(f);
    Factor& factor = factors_[f];
    double* h = hessians_.at(factor.hessian);
    saved_hessians_.save(f, factor.saved, h, factor.size());
    return h;
  }
  const double* points(int f) const { return hessian(f) + packed_size(factors_[f].order); }
  double* points(int f) { return const_cast<double*>(std::as_const(*this).points(f)); }
  /// Begins to load what linear_cost(f) needs.
  void prefetch(int f) const;
  /// Half the squared residual that the linear model of a factor predicts at the present steps.
  double linear_cost(int f) const;
  /// The same at given steps of its variables, one after the other.
  double linear_cost(int f, const double* steps) const;

  struct Mark {
    std::array<std::size_t, kChanges> changes{};
    std::size_t hessians = 0, deltas = 0, numbers = 0;
  };
  void commit() noexcept;
  Mark mark() {
    Mark mark;
    for (int kind = 0; kind < kChanges; ++kind) mark.changes[kind] = changes_[kind].all.size();
    mark.hessians = saved_hessians_.mark();
    mark.deltas = saved_deltas_.mark();
    mark.numbers = factor_numbers_.mark();
    return mark;
  }
  void roll_back(const Mark& mark) noexcept;
  std::size_t bytes() const;

 private:
  struct Variable {
    int dim = 0;
    int clique = -1;
    unsigned saved = 0;  // epoch in which its step was last saved
    bool moved = false;
    std::size_t delta = 0;
  };

  std::vector<Variable> variables_;
  std::vector<Factor> factors_;
  FreeList factor_numbers_;
  Pool hessians_, deltas_;
  Journal<double> saved_hessians_, saved_deltas_;
  std::array<Changes, kChanges> changes_;
  std::vector<int> touched_, moved_;
  bool touches_pending_ = false;
};

}  // namespace hybrid
