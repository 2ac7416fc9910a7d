// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/bayes_tree.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "libhybrid/core/error.h"
#include "libhybrid/linear/scatter.h"

namespace hybrid {
namespace {

/// A pivot below this share of its diagonal entry is rounding error of a singular system.
constexpr double kPivotTolerance = 1e-13;

}  // namespace

void BayesTree::add_variable(int v, int dim) {
  if (v >= static_cast<int>(variables_.size())) {
    variables_.resize(v + 1);
    local_.resize(v + 1, -1);
    offset_.resize(v + 1, -1);
    changed_mark_.resize(v + 1, 0);
  }
  variables_[v].dim = dim;
  variables_[v].clique = -1;
  variables_[v].delta = deltas_.allocate(dim);
  std::fill_n(deltas_.at(variables_[v].delta), dim, 0.0);
  new_variables_.push_back(v);
}

void BayesTree::remove_variable(int v) {
  touch(variables_[v].clique);
  removed_variables_.push_back(v);
}

int BayesTree::add_factor(const std::vector<int>& variables) {
  int f;
  if (free_factors_.empty()) {
    f = static_cast<int>(factors_.size());
    factors_.emplace_back();
  } else {
    f = free_factors_.back();
    free_factors_.pop_back();
  }
  FactorState& factor = factors_[f];
  factor.variables = variables;
  factor.order = 1;
  factor.clique = -1;
  factor.alive = true;
  for (int v : variables) {
    factor.order += variables_[v].dim;
    touch(variables_[v].clique);
  }
  const std::size_t size = static_cast<std::size_t>(factor.order) * factor.order;
  factor.hessian = hessians_.allocate(size);
  std::fill_n(hessians_.at(factor.hessian), size, 0.0);
  new_factors_.push_back(f);
  return f;
}

void BayesTree::remove_factor(int f) {
  factors_[f].alive = false;
  touch(factors_[f].clique);
  removed_factors_.push_back(f);
}

double* BayesTree::hessian(int f) {
  FactorState& factor = factors_[f];
  double* h = hessians_.at(factor.hessian);
  if (factor.clique >= 0) {
    touch(factor.clique);
    saved_hessians_.push_back({f, {h, h + factor.order * factor.order}});
  }
  return h;
}

void BayesTree::reset_delta(int v) {
  double* d = deltas_.at(variables_[v].delta);
  touch(variables_[v].clique);
  saved_deltas_.push_back({v, {d, d + variables_[v].dim}});
  std::fill_n(d, variables_[v].dim, 0.0);
}

int BayesTree::new_clique() {
  ++clique_count_;
  if (free_cliques_.empty()) {
    cliques_.emplace_back();
    return static_cast<int>(cliques_.size()) - 1;
  }
  const int c = free_cliques_.back();
  free_cliques_.pop_back();
  return c;
}

void BayesTree::free_factor(int f) {
  const FactorState& factor = factors_[f];
  hessians_.release(factor.hessian, static_cast<std::size_t>(factor.order) * factor.order);
  free_factors_.push_back(f);
}

void BayesTree::free_clique(int c) {
  Clique& clique = cliques_[c];
  clique.parent = -1;
  clique.children.clear();
  clique.variables.clear();
  clique.factors.clear();
  blocks_.give(std::move(clique.storage));
  clique.detached = false;
  clique.pending = false;
  free_cliques_.push_back(c);
  --clique_count_;
}

void BayesTree::touch(int clique) {
  if (clique >= 0) touched_.push_back(clique);
}

/// Marks the touched cliques and all their ancestors: the part of the tree to be made again.
void BayesTree::detach_top() {
  detached_.clear();
  for (int c : touched_) {
    for (; c >= 0 && !cliques_[c].detached; c = cliques_[c].parent) {
      cliques_[c].detached = true;
      detached_.push_back(c);
    }
  }
  orphans_.clear();
  for (int c : detached_) {
    for (int child : cliques_[c].children) {
      if (!cliques_[child].detached) orphans_.push_back(child);
    }
  }
}

/// The elimination problem of the detached part: its variables, its factors, and what orphans left.
void BayesTree::gather_problem(const std::vector<int>& last) {
  for (int v : removed_variables_) local_[v] = -2;
  affected_.clear();
  const auto take = [&](int v) {
    if (local_[v] != -1) return;
    local_[v] = static_cast<int>(affected_.size());
    affected_.push_back(v);
  };
  for (int c : detached_) {
    for (int k = 0; k < cliques_[c].frontals; ++k) take(cliques_[c].variables[k]);
  }
  for (int v : new_variables_) take(v);

  problem_.clear();
  problem_.count = static_cast<int>(affected_.size());
  for (int v : affected_) problem_.dims.push_back(variables_[v].dim);
  edge_factor_.clear();
  const auto add_factor_edge = [&](int f) {
    if (!factors_[f].alive) return;
    for (int v : factors_[f].variables) problem_.members.push_back(local_[v]);
    problem_.close_edge();
    edge_factor_.push_back(f);
  };
  for (int c : detached_) {
    for (int f : cliques_[c].factors) add_factor_edge(f);
  }
  for (int f : new_factors_) add_factor_edge(f);
  for (int o : orphans_) {
    const Clique& orphan = cliques_[o];
    for (std::size_t k = orphan.frontals; k < orphan.variables.size(); ++k) {
      problem_.members.push_back(local_[orphan.variables[k]]);
    }
    problem_.close_edge();
    edge_factor_.push_back(-1 - o);
  }

  group_.assign(affected_.size(), 0);
  std::size_t constrained = 0;
  for (int v : last) {
    if (local_[v] < 0 || group_[local_[v]] == 1) continue;
    group_[local_[v]] = 1;
    ++constrained;
  }
  if (constrained == affected_.size()) group_.assign(affected_.size(), 0);
}

const double* BayesTree::update_column(const Clique& clique, int k) const {
  const std::size_t m = clique.order - clique.frontal_dim;
  return clique.update + k * m - static_cast<std::size_t>(k) * (k + 1) / 2;
}

/// Sums the factors and the Schur complements of the children into the front.
void BayesTree::assemble(const Clique& clique, const SymbolicClique& symbolic,
                         const std::vector<int>& made) {
  int row = 0;
  for (int v : clique.variables) {
    offset_[v] = row;
    row += variables_[v].dim;
  }
  const int last = clique.order - 1;
  front_.reset(clique.order);
  std::vector<Run> runs;
  const auto scatter_update = [&](const Clique& child) {
    runs.clear();
    int from = 0;
    for (std::size_t k = child.frontals; k < child.variables.size(); ++k) {
      const int v = child.variables[k];
      append_run(runs, from, offset_[v], variables_[v].dim);
      from += variables_[v].dim;
    }
    append_run(runs, from, last, 1);
    scatter(
        runs, [&](int c) { return update_column(child, c); }, front_);
  };
  for (int edge : symbolic.edges) {
    const int f = edge_factor_[edge];
    if (f < 0) {
      scatter_update(cliques_[-1 - f]);
      continue;
    }
    const FactorState& factor = factors_[f];
    runs.clear();
    int from = 0;
    for (int v : factor.variables) {
      append_run(runs, from, offset_[v], variables_[v].dim);
      from += variables_[v].dim;
    }
    append_run(runs, from, last, 1);
    const double* h = hessians_.at(factor.hessian);
    scatter(
        runs, [&](int c) { return h + static_cast<std::size_t>(c) * factor.order; }, front_);
  }
  for (int c : made) scatter_update(cliques_[c]);
}

/// Eliminates one clique whose children among the new cliques are `children`. Returns its number,
/// or -1 - v where variable v is under-constrained.
int BayesTree::make_clique(const SymbolicClique& symbolic, const std::vector<int>& children) {
  const int id = new_clique();
  Clique& clique = cliques_[id];
  clique.frontals = static_cast<int>(symbolic.frontals.size());
  clique.frontal_dim = 0;
  clique.order = 1;
  for (int k : symbolic.frontals) {
    clique.variables.push_back(affected_[k]);
    clique.frontal_dim += problem_.dims[k];
  }
  clique.order += clique.frontal_dim;
  for (int k : symbolic.separators) {
    clique.variables.push_back(affected_[k]);
    clique.order += problem_.dims[k];
  }
  assemble(clique, symbolic, children);
  const int n = clique.order;
  const int f = clique.frontal_dim;
  const int failed = front_.factorize(f, kPivotTolerance);
  if (failed >= 0) {
    int column = 0;
    int k = 0;
    while (column + variables_[clique.variables[k]].dim <= failed) {
      column += variables_[clique.variables[k++]].dim;
    }
    const int v = clique.variables[k];
    free_clique(id);
    return -1 - v;
  }
  const std::size_t m = n - f;
  const std::size_t size = static_cast<std::size_t>(n) * f;
  clique.storage = blocks_.take(size + m * (m + 1) / 2);
  clique.columns = clique.storage.data.get();
  clique.update = clique.columns + size;
  for (int j = 0; j < f; ++j) {
    std::copy_n(front_.column(j) + j, n - j, clique.columns + static_cast<std::size_t>(j) * n + j);
  }
  double* update = clique.update;
  for (int j = f; j < n; ++j) update = std::copy_n(front_.column(j) + j, n - j, update);
  return id;
}

EliminationReport BayesTree::eliminate(const std::vector<int>& last) {
  EliminationReport report;
  detach_top();
  gather_problem(last);
  const std::vector<SymbolicClique> symbolic =
      eliminate_symbolically(problem_, constrained_order(problem_, group_));
  std::vector<std::vector<int>> children(symbolic.size());
  std::vector<int> made;
  for (std::size_t s = 0; s < symbolic.size(); ++s) {
    const int id = make_clique(symbolic[s], children[s]);
    if (id < 0) {
      report.singular = -1 - id;
      for (int c : made) free_clique(c);
      roll_back();
      return report;
    }
    made.push_back(id);
    if (symbolic[s].parent >= 0) children[symbolic[s].parent].push_back(id);
  }
  report.variables = problem_.count;
  report.cliques = static_cast<int>(made.size());
  commit(symbolic, made);
  return report;
}

void BayesTree::commit(const std::vector<SymbolicClique>& symbolic, const std::vector<int>& made) {
  for (std::size_t s = 0; s < made.size(); ++s) {
    Clique& clique = cliques_[made[s]];
    for (int k = 0; k < clique.frontals; ++k) variables_[clique.variables[k]].clique = made[s];
    if (symbolic[s].parent >= 0) {
      clique.parent = made[symbolic[s].parent];
      cliques_[clique.parent].children.push_back(made[s]);
    }
    for (int edge : symbolic[s].edges) {
      const int f = edge_factor_[edge];
      if (f >= 0) {
        factors_[f].clique = made[s];
        clique.factors.push_back(f);
      } else {
        cliques_[-1 - f].parent = made[s];
        clique.children.push_back(-1 - f);
      }
    }
  }
  fresh_.erase(
      std::remove_if(fresh_.begin(), fresh_.end(), [&](int c) { return cliques_[c].detached; }),
      fresh_.end());
  for (int c : detached_) free_clique(c);
  for (int f : removed_factors_) free_factor(f);
  for (int v : removed_variables_) {
    deltas_.release(variables_[v].delta, variables_[v].dim);
    variables_[v].dim = 0;
    variables_[v].clique = -1;
  }
  fresh_.insert(fresh_.end(), made.begin(), made.end());
  clear_transaction();
}

void BayesTree::roll_back() {
  for (int c : detached_) cliques_[c].detached = false;
  for (int f : removed_factors_) factors_[f].alive = true;
  // Backwards: what was saved twice must end as it was at first.
  for (auto saved = saved_hessians_.rbegin(); saved != saved_hessians_.rend(); ++saved) {
    std::copy(saved->values.begin(), saved->values.end(),
              hessians_.at(factors_[saved->id].hessian));
  }
  for (auto saved = saved_deltas_.rbegin(); saved != saved_deltas_.rend(); ++saved) {
    std::copy(saved->values.begin(), saved->values.end(), deltas_.at(variables_[saved->id].delta));
  }
  for (int f : new_factors_) {
    factors_[f].alive = false;
    free_factor(f);
  }
  for (int v : new_variables_) {
    deltas_.release(variables_[v].delta, variables_[v].dim);
    variables_[v].dim = 0;
  }
  clear_transaction();
}

void BayesTree::clear_transaction() {
  for (int v : affected_) local_[v] = -1;
  for (int v : removed_variables_) local_[v] = -1;
  touched_.clear();
  new_variables_.clear();
  removed_variables_.clear();
  new_factors_.clear();
  removed_factors_.clear();
  saved_hessians_.clear();
  saved_deltas_.clear();
}

}  // namespace hybrid
