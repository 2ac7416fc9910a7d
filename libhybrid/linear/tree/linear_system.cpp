// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/tree/linear_system.h"

#include "libhybrid/core/prefetch.h"

namespace hybrid {
namespace {

/// d' H d / 2 for a symmetric matrix given by its packed lower triangle, of order N, or n if N is
/// zero, and steps that 1 follows in d. Sums by columns, so that the compiler can take several rows
/// at once.
template <int N>
double half_quadratic(const double* h, const double* steps, int n) {
  const int order = N > 0 ? N : n;
  std::array<double, 2 * N> few;
  std::vector<double> many(N > 0 ? 0 : 2 * n);
  double* d = N > 0 ? few.data() : many.data();
  double* y = d + order;  // of the lower triangle, times d
  *std::copy_n(steps, order - 1, d) = 1.0;
  std::fill_n(y, order, 0.0);
  for (int j = 0; j < order; ++j) {
    const double* column = packed_column(h, order, j);
    const double x = d[j];
    y[j] += 0.5 * column[j] * x;
    for (int i = j + 1; i < order; ++i) y[i] += column[i] * x;
  }
  double sum = 0.0;
  for (int i = 0; i < order; ++i) sum += y[i] * d[i];
  return sum;
}

}  // namespace

void LinearSystem::add_variable(int v, int dim) {
  if (v >= variable_count()) variables_.resize(v + 1);
  changes_[kNewVariables].all.push_back(v);
  Variable& variable = variables_[v];
  variable.delta = deltas_.allocate(dim);
  variable.dim = dim;
  variable.clique = -1;
  variable.saved = saved_deltas_.epoch();
  std::fill_n(deltas_.at(variable.delta), dim, 0.0);
}

int LinearSystem::add_factor(const std::vector<int>& variables, int points) {
  const int f = factor_numbers_.take();
  if (f >= static_cast<int>(factors_.size())) factors_.resize(f + 1);
  Factor& factor = factors_[f];
  factor.variables = variables;
  factor.order = 1;
  for (int v : variables) factor.order += dim(v);
  factor.points = points;
  changes_[kNewFactors].all.push_back(f);
  factor.hessian = hessians_.allocate(factor.size());
  factor.clique = -1;
  factor.alive = true;
  factor.saved = saved_hessians_.epoch();
  std::fill_n(hessians_.at(factor.hessian), factor.size(), 0.0);
  return f;
}

void LinearSystem::prefetch(int f) const {
  hybrid::prefetch(hessian(f), factors_[f].size() * sizeof(double));
}

double LinearSystem::linear_cost(int f) const {
  const Factor& factor = factors_[f];
  std::vector<double> steps(factor.order);
  copy_deltas(factor.variables, 0, factor.variables.size(), steps.data());
  return linear_cost(f, steps.data());
}

double LinearSystem::linear_cost(int f, const double* steps) const {
  const int n = factors_[f].order;
  switch (n) {
    case 6:
      return half_quadratic<6>(hessian(f), steps, n);
    case 7:
      return half_quadratic<7>(hessian(f), steps, n);
    case 13:
      return half_quadratic<13>(hessian(f), steps, n);
    default:
      return half_quadratic<0>(hessian(f), steps, n);
  }
}

void LinearSystem::commit() noexcept {
  for (int f : changes_[kRemovedFactors].all) {
    hessians_.release(factors_[f].hessian, factors_[f].size());
    factor_numbers_.give(f);
  }
  for (int v : changes_[kRemovedVariables].all) {
    deltas_.release(variables_[v].delta, variables_[v].dim);
    variables_[v] = {};
  }
  factor_numbers_.commit();
  saved_hessians_.commit();
  saved_deltas_.commit();
  for (Changes& changes : changes_) changes.all.clear();
  note_eliminated();
}

void LinearSystem::roll_back(const Mark& mark) noexcept {
  take_moved();
  // While all that was saved is still there.
  saved_hessians_.roll_back(mark.hessians,
                            [&](int f) { return hessians_.at(factors_[f].hessian); });
  saved_deltas_.roll_back(mark.deltas, [&](int v) { return deltas_.at(variables_[v].delta); });
  const auto undo = [&](Change kind, const auto& each) {
    std::vector<int>& all = changes_[kind].all;
    for (std::size_t i = mark.changes[kind]; i < all.size(); ++i) each(all[i]);
    all.resize(mark.changes[kind]);
  };
  undo(kRemovedFactors, [&](int f) { factors_[f].alive = true; });
  undo(kNewFactors, [&](int f) {
    if (factors_[f].alive) hessians_.release(factors_[f].hessian, factors_[f].size());
    factors_[f].alive = false;
  });
  undo(kRemovedVariables, [](int) {});
  undo(kNewVariables, [&](int v) {
    if (dim(v) > 0) deltas_.release(variables_[v].delta, dim(v));
    variables_[v] = {};
  });
  note_eliminated();
  factor_numbers_.roll_back(mark.numbers);
}

std::size_t LinearSystem::bytes() const {
  std::size_t bytes = hessians_.bytes() + deltas_.bytes() + factors_.capacity() * sizeof(Factor) +
                      variables_.capacity() * sizeof(Variable);
  for (const Factor& factor : factors_) bytes += factor.variables.capacity() * sizeof(int);
  return bytes;
}

}  // namespace hybrid
