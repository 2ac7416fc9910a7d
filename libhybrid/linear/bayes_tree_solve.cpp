// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "libhybrid/core/detail/prefetch.h"
#include "libhybrid/core/paced_task.h"
#include "libhybrid/linear/bayes_tree.h"
#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {
namespace {

constexpr int kFewColumns = 16;

/// Of what new steps bring, the share that it may cost that parts of the tree stay.
constexpr double kShareForRest = 0.5;

/// d' H d / 2 for a symmetric matrix given by its packed lower triangle, of order N, or n if N is
/// zero. Sums by columns, so that the compiler can take several rows at once.
template <int N>
double half_quadratic(const double* h, const double* d, int n) {
  const int order = N > 0 ? N : n;
  std::array<double, N> few;
  std::vector<double> many(N > 0 ? 0 : n);
  double* y = N > 0 ? few.data() : many.data();  // of the lower triangle, times d
  std::fill_n(y, order, 0.0);
  for (int j = 0; j < order; ++j) {
    const double* column = packed_column(h, order, j);
    y[j] += 0.5 * column[j] * d[j];
    for (int i = j + 1; i < order; ++i) y[i] += column[i] * d[j];
  }
  double sum = 0.0;
  for (int i = 0; i < order; ++i) sum += y[i] * d[i];
  return sum;
}

}  // namespace

/// Gathers the steps of a clique's variables and its right-hand side given the steps that it sees
/// of its separator. Returns by how much solving for the frontals lowers the linearised objective.
double BayesTree::prepare(const Clique& clique, const double* seen) {
  note_work(2.0 * clique.order * clique.frontal_dim);
  const int n = clique.order;
  const int f = clique.frontal_dim;
  step_.resize(n);
  double* to = step_.data();
  for (int k = 0; k < clique.frontals; ++k) {
    const VariableState& variable = variables_[clique.variables[k]];
    to = std::copy_n(deltas_.at(variable.delta), variable.dim, to);
  }
  const int s = n - 1 - f;
  std::copy_n(seen, s, to);
  rhs_.resize(f);
  const auto dot = kernels().dot;
  double gain = 0.0;
  for (int j = 0; j < f; ++j) {
    const double* column = clique.columns() + static_cast<std::size_t>(j) * n;
    rhs_[j] = column[n - 1] + dot(column + f, step_.data() + f, s);
    const double left = rhs_[j] + dot(column + j, step_.data() + j, f - j);
    gain += left * left;
  }
  return 0.5 * gain;
}

/// Solves for the frontals of the clique that was prepared last.
void BayesTree::solve_prepared(Clique& clique, Charts* charts) {
  const int n = clique.order;
  const int f = clique.frontal_dim;
  const auto dot = kernels().dot;
  for (int j = f - 1; j >= 0; --j) {
    const double* column = clique.columns() + static_cast<std::size_t>(j) * n;
    step_[j] = -(rhs_[j] + dot(column + j + 1, step_.data() + j + 1, f - 1 - j)) / column[j];
  }
  const double* from = step_.data();
  for (int k = 0; k < clique.frontals; ++k) {
    const int v = clique.variables[k];
    save_delta(v);
    std::copy_n(from, variables_[v].dim, deltas_.at(variables_[v].delta));
    from += variables_[v].dim;
  }
  list_changed(clique, 0, clique.frontals);
  if (charts != nullptr) {
    charts->place(clique.variables, clique.frontals, clique.chart(), step_.data());
  }
}

void BayesTree::list_changed(const Clique& clique, std::size_t from, std::size_t to) {
  for (std::size_t k = from; k < to; ++k) {
    const int v = clique.variables[k];
    if (changed_mark_[v] != 0) continue;
    changed_mark_[v] = 1;
    changed_.push_back(v);
  }
}

/// Solves the ancestors of a clique that were visited and kept their steps, from the top, and puts
/// what is below them, the clique too, on the stack once more. Returns whether there were any.
bool BayesTree::solve_kept_ancestors(int c, std::vector<int>& stack, Charts* charts) {
  kept_.clear();
  for (int a = cliques_[c].parent; a >= 0 && cliques_[a].visit == Clique::Visit::kKept;
       a = cliques_[a].parent) {
    kept_.push_back(a);
  }
  for (auto a = kept_.rbegin(); a != kept_.rend(); ++a) {
    Clique& clique = cliques_[*a];
    see(clique, charts);
    save_seen(*a);
    std::copy(view_.begin(), view_.end(), clique.seen());
    prepare(clique, clique.seen());
    solve_prepared(clique, charts);
    clique.visit = Clique::Visit::kSolved;
    stack.insert(stack.end(), clique.children.begin(), clique.children.end());
  }
  return !kept_.empty();
}

/// Solves cliques on the stack and below. Where that gains no more than the threshold a clique
/// keeps its steps, and what is below is visited all the same: the change above may matter there.
/// But before anything is solved below it, it is solved itself. Else its error, worth little there,
/// would be a bend of all that hangs on it: a chain of a kilometre would swing to and fro.
void BayesTree::propagate(std::vector<int>& stack, double threshold, const Bend& bend,
                          Charts* charts) {
  while (!stack.empty()) {
    const int c = stack.back();
    stack.pop_back();
    Clique& clique = cliques_[c];
    if (clique.visit == Clique::Visit::kSolved || is_left(c, bend, charts)) continue;
    const bool worth = prepare(clique, clique.seen()) > threshold;
    if (worth && solve_kept_ancestors(c, stack, charts)) {
      clique.pending = true;  // what it sees next is not compared with what it has seen now
      continue;
    }
    if (worth && follow_.found) {
      std::copy(follow_.in_all.begin(), follow_.in_all.end(), clique.motion());
      std::copy(follow_.view.begin(), follow_.view.end(), clique.seen());
      prepare(clique, clique.seen());
    }
    if (worth) solve_prepared(clique, charts);
    if (clique.visit == Clique::Visit::kNone) visited_.push_back(c);
    clique.visit = worth ? Clique::Visit::kSolved : Clique::Visit::kKept;
    clique.pending = false;
    stack.insert(stack.end(), clique.children.begin(), clique.children.end());
  }
}

/// By how much the cliques that are to be solved lower the linearised objective, if all below them
/// follows.
double BayesTree::promise(const Charts* charts) {
  double gain = 0.0;
  for (const std::vector<int>* cliques : {&fresh_, &pending_}) {
    for (int c : *cliques) {
      see(cliques_[c], charts);
      gain += prepare(cliques_[c], view_.data());
    }
  }
  return gain;
}

const std::vector<int>& BayesTree::solve(double threshold, const Bend& bend, Charts* charts) {
  changed_.clear();
  may_rise_ = kShareForRest * promise(charts);
  // All above a new clique is new.
  std::vector<int> stack;
  for (int c : fresh_) {
    cliques_[c].pending = true;
    if (cliques_[c].parent < 0) stack.push_back(c);
  }
  propagate(stack, threshold, bend, charts);
  for (int c : pending_) {
    if (!cliques_[c].pending) continue;
    stack.push_back(c);
    propagate(stack, threshold, bend, charts);
  }
  reset_marks();
  fresh_.clear();
  pending_.clear();
  return changed_;
}

/// Resets the marks of a solution, finished or interrupted.
void BayesTree::reset_marks() {
  for (int c : fresh_) cliques_[c].pending = false;
  for (int c : pending_) cliques_[c].pending = false;
  for (int c : visited_) cliques_[c].visit = Clique::Visit::kNone;
  visited_.clear();
  for (int v : changed_) changed_mark_[v] = 0;
}

void BayesTree::prefetch(int f) const {
  const FactorState& factor = factors_[f];
  hybrid::prefetch(hessians_.at(factor.hessian), factor.size() * sizeof(double));
}

double BayesTree::linear_cost(int f) const {
  const FactorState& factor = factors_[f];
  std::vector<double> steps;
  for (int v : factor.variables) {
    const double* delta = deltas_.at(variables_[v].delta);
    steps.insert(steps.end(), delta, delta + variables_[v].dim);
  }
  return linear_cost(f, steps.data());
}

double BayesTree::linear_cost(int f, const double* steps) const {
  const double* h = hessians_.at(factors_[f].hessian);
  const int n = factors_[f].order;
  double few[kFewColumns];
  std::vector<double> many(n > kFewColumns ? n : 0);
  double* d = n > kFewColumns ? many.data() : few;
  std::copy_n(steps, n - 1, d);
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
