// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Re-elimination of the part of the tree that a change touches.
#include <algorithm>
#include <array>
#include <cmath>

#include "libhybrid/core/paced_task.h"
#include "libhybrid/geometry/eigen.h"
#include "libhybrid/linear/bayes_tree.h"
#include "libhybrid/linear/detail/scatter.h"

namespace hybrid {

/// Marks the touched cliques and all their ancestors: the part of the tree to be eliminated again.
void BayesTree::detach_top() {
  detached_.clear();
  for (int c : touched_) {
    for (; c >= 0 && !cliques_[c].detached; c = cliques_[c].parent) {
      detached_.push_back(c);
      cliques_[c].detached = true;
    }
  }
  orphans_.clear();
  for (int c : detached_) {
    for (int child : cliques_[c].children) {
      if (!cliques_[child].detached) orphans_.push_back(child);
    }
  }
}

const std::vector<int>& BayesTree::factors_to_assemble() {
  detach_top();
  to_assemble_.clear();
  const auto take = [this](int f) {
    if (factors_[f].alive) to_assemble_.push_back(f);
  };
  for (int c : detached_) {
    std::for_each(cliques_[c].factors.begin(), cliques_[c].factors.end(), take);
    cliques_[c].detached = false;
  }
  std::for_each(new_factors_.begin(), new_factors_.end(), take);
  detached_.clear();
  return to_assemble_;
}

/// The elimination problem of the detached part: its variables, its factors, and the separators of
/// the subtrees below it (orphans).
void BayesTree::gather_problem() {
  affected_.clear();
  for (int v : removed_variables_) local_[v] = -2;
  const auto take = [&](int v) {
    if (local_[v] != -1) return;
    affected_.push_back(v);
    local_[v] = static_cast<int>(affected_.size()) - 1;
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
}

/// Groups the variables of the problem, without gaps, in the order in which they are eliminated.
void BayesTree::group_problem(const std::vector<int>& last, const std::vector<int>& behind) {
  group_.assign(affected_.size(), 0);
  for (int v : last) {
    if (local_[v] >= 0) group_[local_[v]] = 1;
  }
  for (int v : behind) {
    if (local_[v] >= 0) group_[local_[v]] = 2;
  }
  std::array<bool, 3> used{};
  for (int group : group_) used[group] = true;
  const std::array<int, 3> number = {0, used[0] ? 1 : 0, (used[0] ? 1 : 0) + (used[1] ? 1 : 0)};
  for (int& group : group_) group = number[group];
}

void BayesTree::assemble_factor(const FactorState& factor, int last) {
  const double* hessian = hessians_.at(factor.hessian);
  std::vector<Run> runs;
  int from = 0;
  for (int v : factor.variables) {
    const int dim = variables_[v].dim;
    append_run(runs, from, offset_[v], dim);
    for (int k = 0; k < dim; ++k, ++from) {
      scale_[v] += packed_column(hessian, factor.order, from)[from];
    }
  }
  append_run(runs, from, last, 1);
  scatter(
      runs, [&](int c) { return packed_column(hessian, factor.order, c); }, front_);
}

void BayesTree::scatter_update(const Clique& child, const double* update, int last) {
  std::vector<Run> runs;
  const double* scales = child.scales();
  const int order = child.order - child.frontal_dim;
  int from = 0;
  for (std::size_t k = child.frontals; k < child.variables.size(); ++k) {
    const int v = child.variables[k];
    append_run(runs, from, offset_[v], variables_[v].dim);
    from += variables_[v].dim;
    scale_[v] += *scales++;
  }
  append_run(runs, from, last, 1);
  scatter(
      runs, [&](int c) { return packed_column(update, order, c); }, front_);
}

void BayesTree::assemble_update(const Clique& child, int last, const Charts* charts) {
  const double* update = child.update(0);
  if (charts == nullptr) return scatter_update(child, update, last);
  Chart own = child.chart();
  if (find_motion(child, *charts)) own.motion = follow_.in_all.data();
  carry_over(child.variables, child.frontals, own, update, child.order - child.frontal_dim,
             *charts);
  scatter_update(child, carried_.data(), last);
}

/// Sums the factors and the Schur complements of the children into the front.
void BayesTree::assemble(const Clique& clique, const SymbolicClique& symbolic,
                         const std::vector<int>& made, const Charts* charts) {
  int row = 0;
  for (int v : clique.variables) {
    offset_[v] = row;
    scale_[v] = 0.0;
    row += variables_[v].dim;
  }
  const int last = clique.order - 1;
  front_.reset(clique.order);
  for (int edge : symbolic.edges) {
    const int f = edge_factor_[edge];
    f >= 0 ? assemble_factor(factors_[f], last) : assemble_update(cliques_[-1 - f], last, charts);
  }
  for (int c : made) assemble_update(cliques_[c], last, nullptr);
}

/// Sets the least pivots of the front; 1 for a variable in no factor.
void BayesTree::set_thresholds(const Clique& clique) {
  least_.clear();
  for (int k = 0; k < clique.frontals; ++k) {
    const int v = clique.variables[k];
    least_.insert(least_.end(), variables_[v].dim, scale_[v] > 0.0 ? kPivotShare * scale_[v] : 1.0);
  }
}

/// Lets lifted pivots hold the present steps: what was added to a pivot pulls to them, not to zero.
/// So the steps end where they would without it, after as many eliminations as that takes.
void BayesTree::hold_lifted(const Clique& clique) {
  if (lifted_.empty()) return;
  const int n = clique.order;
  const int f = clique.frontal_dim;
  std::vector<double> steps;
  for (int k = 0; k < clique.frontals; ++k) {
    const VariableState& variable = variables_[clique.variables[k]];
    const double* delta = deltas_.at(variable.delta);
    steps.insert(steps.end(), delta, delta + variable.dim);
  }
  std::vector<double> pull(n - 1, 0.0);  // on the right-hand side, before elimination
  for (int j : lifted_) {
    double pivot = diagonal_[j];
    for (int k = 0; k < j; ++k) pivot -= front_.column(k)[j] * front_.column(k)[j];
    pull[j] = -(least_[j] - pivot) * steps[j];
  }
  for (int j = 0; j < f; ++j) {
    const double* column = front_.column(j);
    const double x = pull[j] / column[j];
    for (int i = j + 1; i < n - 1; ++i) pull[i] -= column[i] * x;
    front_.column(j)[n - 1] += x;
  }
  for (int i = f; i < n - 1; ++i) front_.column(i)[n - 1] += pull[i];
}

/// Eliminates one clique whose children among the new cliques are `children`. Returns its number,
/// or -1 - v if the pivot of variable v is not finite.
int BayesTree::make_clique(const SymbolicClique& symbolic, const std::vector<int>& children,
                           const Charts* charts) {
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
  assemble(clique, symbolic, children, charts);
  set_thresholds(clique);
  const int n = clique.order;
  const int f = clique.frontal_dim;
  const auto variable_of = [&](int column) {
    int k = 0;
    while (column >= variables_[clique.variables[k]].dim) {
      column -= variables_[clique.variables[k++]].dim;
    }
    return clique.variables[k];
  };
  lifted_.clear();
  diagonal_.resize(f);
  for (int j = 0; j < f; ++j) diagonal_[j] = front_.column(j)[j];
  const int failed = front_.factorize(f, least_.data(), lifted_);
  note_work(double(f) * n * n);
  if (failed >= 0) return -1 - variable_of(failed);
  for (int column : lifted_) lifted_variables_.push_back(variable_of(column));
  if (charts == nullptr) hold_lifted(clique);  // steps begin at zero otherwise

  const std::size_t m = n - f;
  const std::size_t separators = clique.variables.size() - clique.frontals;
  clique.charted = charts != nullptr;
  clique.storage =
      Block(static_cast<std::size_t>(n) * f + packed_size(m) + separators + clique.seen_size() +
            (clique.charted ? charts->size(clique.variables) : 0));
  double* to = clique.columns();
  for (int j = 0; j < f; ++j, to += n) std::copy_n(front_.column(j) + j, n - j, to + j);
  for (int j = f; j < n; ++j) to = std::copy_n(front_.column(j) + j, n - j, to);
  for (std::size_t k = clique.frontals; k < clique.variables.size(); ++k) {
    *to++ = scale_[clique.variables[k]];
  }
  std::fill_n(clique.seen(), clique.seen_size(), 0.0);
  if (clique.charted) charts->start(clique.variables, clique.seen() + clique.seen_size());
  return id;
}

EliminationReport BayesTree::eliminate(const std::vector<int>& last,
                                       const IsDetermined& is_determined,
                                       const std::vector<int>& behind, const Charts* charts) {
  EliminationReport report;
  const std::size_t born_before = born_.size();
  detach_top();
  gather_problem();
  group_problem(last, behind);
  lifted_variables_.clear();
  const std::vector<SymbolicClique> symbolic =
      eliminate_symbolically(problem_, constrained_order(problem_, group_));
  std::vector<std::vector<int>> children(symbolic.size());
  std::vector<int> made;
  for (std::size_t s = 0; s < symbolic.size(); ++s) {
    const int id = make_clique(symbolic[s], children[s], charts);
    if (id < 0) {
      report.singular = -1 - id;
      break;
    }
    made.push_back(id);
    if (symbolic[s].parent >= 0) children[symbolic[s].parent].push_back(id);
  }
  if (report.singular < 0 && !lifted_variables_.empty() &&
      !(is_determined && is_determined(lifted_variables_))) {
    report.singular = lifted_variables_.front();
  }
  reset_local();
  if (report.singular >= 0) {
    refuse(born_before);
    return report;
  }
  report.variables = problem_.count;
  report.cliques = static_cast<int>(made.size());
  attach(symbolic, made, charts);
  return report;
}

void BayesTree::reset_local() {
  for (int v : affected_) local_[v] = -1;
  for (int v : removed_variables_) local_[v] = -1;
}

/// Restores the tree as it was before `eliminate`, which made the cliques from born_[first] on.
void BayesTree::refuse(std::size_t first) {
  for (int c : detached_) cliques_[c].detached = false;
  detached_.clear();
  for (std::size_t k = first; k < born_.size(); ++k) free_clique(born_[k]);
  born_.resize(first);
}

/// Replaces the detached cliques by the new ones.
void BayesTree::attach(const std::vector<SymbolicClique>& symbolic, const std::vector<int>& made,
                       const Charts* charts) {
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
    clique.factors_below = static_cast<int>(clique.factors.size());
    for (int child : clique.children) clique.factors_below += cliques_[child].factors_below;
  }
  if (charts != nullptr) {
    set_free(made, *charts);
    for (int v : affected_) {
      save_delta(v);
      std::fill_n(deltas_.at(variables_[v].delta), variables_[v].dim, 0.0);
    }
  }
  const auto is_detached = [&](int c) { return cliques_[c].detached; };
  fresh_.erase(std::remove_if(fresh_.begin(), fresh_.end(), is_detached), fresh_.end());
  pending_.erase(std::remove_if(pending_.begin(), pending_.end(), is_detached), pending_.end());
  fresh_.insert(fresh_.end(), made.begin(), made.end());
  base_.fresh.reserve(fresh_.capacity());
  for (int c : detached_) {
    cliques_[c].pending = false;
    if (cliques_[c].born == epoch_) {
      free_clique(c);
    } else {
      retired_.push_back(c);
    }
  }
  detached_.clear();
  touched_.clear();
  for (Changes* changes :
       {&new_variables_, &removed_variables_, &new_factors_, &removed_factors_}) {
    changes->pending = changes->all.size();
  }
}

}  // namespace hybrid
