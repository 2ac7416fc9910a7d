// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <algorithm>
#include <cmath>
#include <vector>

#include "libhybrid/core/detail/prefetch.h"
#include "libhybrid/linear/bayes_tree.h"
#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {
namespace {

constexpr int kFewColumns = 16;

/// d' H d / 2 for a symmetric matrix given by its packed lower triangle, of order N, or n if N is
/// zero.
template <int N>
double half_quadratic(const double* h, const double* d, int n) {
  const int order = N > 0 ? N : n;
  double sum = 0.0;
  for (int j = 0; j < order; ++j) {
    const double* column = packed_column(h, order, j);
    double below = 0.5 * column[j] * d[j];
    for (int i = j + 1; i < order; ++i) below += column[i] * d[i];
    sum += below * d[j];
  }
  return sum;
}

}  // namespace

/// Solves for the frontals of a clique if that lowers the objective by more than the threshold, and
/// returns whether it did; if not, the old steps stay.
bool BayesTree::solve_clique(Clique& clique, double threshold) {
  const int n = clique.order;
  const int f = clique.frontal_dim;
  step_.resize(n);
  int row = f;
  for (std::size_t k = clique.frontals; k < clique.variables.size(); ++k) {
    const VariableState& variable = variables_[clique.variables[k]];
    std::copy_n(deltas_.at(variable.delta), variable.dim, step_.data() + row);
    row += variable.dim;
  }
  clique.pending = false;
  // The right-hand side given the separator, and its residual at the old steps.
  row = 0;
  for (int k = 0; k < clique.frontals; ++k) {
    const VariableState& variable = variables_[clique.variables[k]];
    std::copy_n(deltas_.at(variable.delta), variable.dim, step_.data() + row);
    row += variable.dim;
  }
  const int s = n - 1 - f;
  rhs_.resize(f);
  const auto dot = kernels().dot;
  double gain = 0.0;
  for (int j = 0; j < f; ++j) {
    const double* column = clique.columns() + static_cast<std::size_t>(j) * n;
    rhs_[j] = column[n - 1] + dot(column + f, step_.data() + f, s);
    const double left = rhs_[j] + dot(column + j, step_.data() + j, f - j);
    gain += left * left;
  }
  if (!(0.5 * gain > threshold)) return false;
  for (int j = f - 1; j >= 0; --j) {
    const double* column = clique.columns() + static_cast<std::size_t>(j) * n;
    step_[j] = -(rhs_[j] + dot(column + j + 1, step_.data() + j + 1, f - 1 - j)) / column[j];
  }
  row = 0;
  for (int k = 0; k < clique.frontals; ++k) {
    const int v = clique.variables[k];
    save_delta(v);
    std::copy_n(step_.data() + row, variables_[v].dim, deltas_.at(variables_[v].delta));
    row += variables_[v].dim;
    changed_.push_back(v);
    changed_mark_[v] = 1;
  }
  return true;
}

/// Solves the cliques on the stack and below whose separator changed or whose step was overridden.
void BayesTree::propagate(std::vector<int>& stack, double threshold) {
  while (!stack.empty()) {
    Clique& clique = cliques_[stack.back()];
    stack.pop_back();
    bool needed = clique.pending;
    for (std::size_t k = clique.frontals; k < clique.variables.size() && !needed; ++k) {
      needed = changed_mark_[clique.variables[k]] != 0;
    }
    clique.pending = false;
    if (!needed) continue;
    // Even if its own steps stay, the change above may matter further down.
    solve_clique(clique, threshold);
    for (int child : clique.children) stack.push_back(child);
  }
}

const std::vector<int>& BayesTree::solve(double threshold) {
  changed_.clear();
  // New cliques in reverse order of their making, parents first; then those with overridden steps,
  // in the order of the calls.
  for (int c : fresh_) cliques_[c].detached = true;
  std::vector<int> stack;
  for (auto it = fresh_.rbegin(); it != fresh_.rend(); ++it) {
    solve_clique(cliques_[*it], threshold);
    for (int child : cliques_[*it].children) {
      if (!cliques_[child].detached) stack.push_back(child);
    }
  }
  for (int c : fresh_) cliques_[c].detached = false;
  fresh_.clear();
  propagate(stack, threshold);
  pending_now_ = pending_;
  pending_.clear();
  for (int c : pending_now_) {
    if (!cliques_[c].pending) continue;
    stack.push_back(c);
    propagate(stack, threshold);
  }
  for (int v : changed_) changed_mark_[v] = 0;
  return changed_;
}

void BayesTree::prefetch(int f) const {
  const FactorState& factor = factors_[f];
  hybrid::prefetch(hessians_.at(factor.hessian), packed_size(factor.order) * sizeof(double));
  hybrid::prefetch(factor.variables.data(), factor.variables.size() * sizeof(int));
}

double BayesTree::linear_cost(int f) const {
  const FactorState& factor = factors_[f];
  const double* h = hessians_.at(factor.hessian);
  const int n = factor.order;
  double step[kFewColumns];
  std::vector<double> many(n > kFewColumns ? n : 0);
  double* d = n > kFewColumns ? many.data() : step;
  int row = 0;
  for (int v : factor.variables) {
    std::copy_n(deltas_.at(variables_[v].delta), variables_[v].dim, d + row);
    row += variables_[v].dim;
  }
  d[n - 1] = 1.0;
  switch (n) {
    case 6:
      return half_quadratic<6>(h, d, n);
    case 7:
      return half_quadratic<7>(h, d, n);
    case 13:
      return half_quadratic<13>(h, d, n);
    default:
      return half_quadratic<0>(h, d, n);
  }
}

std::size_t BayesTree::factor_size() const {
  std::size_t size = 0;
  for (const Clique& clique : cliques_) {
    if (clique.variables.empty() || clique.detached) continue;
    const std::size_t f = clique.frontal_dim;
    size += f * (clique.order - 1) - f * (f - 1) / 2;
  }
  return size;
}

}  // namespace hybrid
