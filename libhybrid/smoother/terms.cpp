// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/terms.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <utility>

#include "libhybrid/core/prefetch.h"
#include "libhybrid/linear/with_dim.h"

namespace hybrid {
namespace {

/// The packed lower triangle h = A'A for the whitened A = [J r] of M rows and n columns.
template <int M>
void square(const double* a, int rows, int n, double* h) {
  using Augmented = Eigen::Matrix<double, M, Eigen::Dynamic>;
  const Eigen::Map<const Augmented> A(a, rows, n);
  for (int j = 0; j < n; ++j) {
    Eigen::Map<Eigen::VectorXd> column(packed_column(h, n, j) + j, n - j);
    column.noalias() = A.rightCols(n - j).transpose().lazyProduct(A.col(j));
  }
}

/// Each variable of a weak component gets its share of the gradient, and no curvature.
void write_pulls(const Term& term, const double* a, BayesTree& tree) {
  const ContinuousFactor& factor = *term.component.factor;
  const Eigen::Map<const Eigen::MatrixXd> A(a, factor.rows(), factor.cols() + 1);
  int column = 0;
  for (std::size_t i = 0; i < term.pulls.size(); ++i) {
    const int dim = factor.types()[i].dim;
    double* h = tree.hessian(term.pulls[i]);
    for (int c = 0; c < dim; ++c) {
      packed_column(h, dim + 1, c)[dim] = A.rightCols(1).col(0).dot(A.col(column + c));
    }
    column += dim;
  }
}

}  // namespace

double evaluate(const Term& term, const Values& values) {
  const ContinuousFactor* factor = term.component.factor;
  if (factor == nullptr) return term.constant;
  return term.constant + factor->cost(TermPointers(term, values).data());
}

void linearize(Term& term, const Values& values, BayesTree& tree) {
  if (term.tree_factor < 0 && term.pulls.empty()) return;
  const ContinuousFactor& factor = *term.component.factor;
  const int rows = factor.rows();
  const int n = factor.cols() + 1;
  std::array<double, 128> few;
  std::vector<double> many;
  if (static_cast<std::size_t>(rows) * n > few.size())
    many.resize(static_cast<std::size_t>(rows) * n);
  double* a = many.empty() ? few.data() : many.data();
  double* r = a + static_cast<std::size_t>(rows) * (n - 1);
  const double cost = factor.linearize(TermPointers(term, values).data(), r, a);
  term.model_offset = cost - 0.5 * Eigen::Map<const Eigen::VectorXd>(r, rows).squaredNorm();
  term.model_error = 0.0;
  if (!term.pulls.empty()) return write_pulls(term, a, tree);
  double* h = tree.hessian(term.tree_factor);
  double* point = tree.points(term.tree_factor);
  const TermPointers x(term, values);
  for (std::size_t i = 0; i < factor.types().size(); ++i)
    point = std::copy_n(x.data()[i], factor.types()[i].size, point);
  with_dim(rows, [&](auto known) { square<decltype(known)::value>(a, rows, n, h); });
}

int point_size(const ContinuousFactor& factor) {
  int size = 0;
  for (const VariableType type : factor.types()) size += type.size;
  return size;
}

std::vector<int> active_slots(const Term& term) {
  const std::size_t n = term.component.factor->keys().size();
  std::vector<int> slots(n);
  for (std::size_t i = 0; i < n; ++i) {
    slots[i] = term.slots[term.component.positions ? term.component.positions[i] : i];
  }
  return slots;
}

void Terms::prefetch(int t) const {
  hybrid::prefetch(&terms_[t], sizeof(Term));
}

int Terms::add(Term term) {
  const int t = numbers_.take();
  if (t >= count()) terms_.resize(t + 1);
  added_.push_back(t);
  terms_[t] = std::move(term);
  Term& added = terms_[t];
  added.alive = true;
  added.saved = saved_.epoch();
  for (int slot : added.slots) {
    reserve_variable(slot);
    adjacency_[slot].push_back(t);
  }
  return t;
}

void Terms::remove(int t) {
  edit(t).alive = false;
  removed_.push_back(t);
}

/// Forgets a term; the newest of a variable is found first.
void Terms::take_out(int t) {
  for (int slot : terms_[t].slots) {
    if (slot >= static_cast<int>(adjacency_.size())) continue;
    std::vector<int>& list = adjacency_[slot];
    const auto at = std::find(list.rbegin(), list.rend(), t);
    if (at != list.rend()) list.erase(at.base() - 1);
  }
  terms_[t] = {};
}

void Terms::commit() noexcept {
  for (int t : removed_) {
    take_out(t);
    numbers_.give(t);
  }
  numbers_.commit();
  added_.clear();
  removed_.clear();
  saved_.commit();
}

void Terms::roll_back(const Mark& mark) noexcept {
  saved_.roll_back(mark.saved, [this](int t) -> TermState* { return &terms_[t]; });
  for (; added_.size() > mark.added; added_.pop_back()) take_out(added_.back());
  removed_.resize(mark.removed);
  numbers_.roll_back(mark.numbers);
}

std::size_t Terms::bytes() const {
  std::size_t bytes =
      terms_.capacity() * sizeof(Term) + adjacency_.capacity() * sizeof(std::vector<int>);
  for (const Term& term : terms_) bytes += term.slots.capacity() * sizeof(int);
  for (const auto& list : adjacency_) bytes += list.capacity() * sizeof(int);
  return bytes;
}

}  // namespace hybrid
