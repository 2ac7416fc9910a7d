// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Changes of the tree, commit and roll-back.
#include "libhybrid/linear/bayes_tree.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "libhybrid/core/detail/sort_unique.h"

namespace hybrid {

void BayesTree::add_variable(int v, int dim) {
  if (v >= static_cast<int>(variables_.size())) {
    local_.resize(v + 1, -1);
    offset_.resize(v + 1, -1);
    scale_.resize(v + 1, 0.0);
    changed_mark_.resize(v + 1, 0);
    variables_.resize(v + 1);
  }
  new_variables_.all.push_back(v);
  VariableState& variable = variables_[v];
  variable.delta = deltas_.allocate(dim);
  variable.dim = dim;
  variable.clique = -1;
  variable.saved = epoch_;
  std::fill_n(deltas_.at(variable.delta), dim, 0.0);
}

void BayesTree::remove_variable(int v) {
  touch(variables_[v].clique);
  removed_variables_.all.push_back(v);
}

int BayesTree::add_factor(const std::vector<int>& variables) {
  return add_factor(variables, 0);
}

int BayesTree::add_factor(const std::vector<int>& variables, int points) {
  const int f = factor_numbers_.take();
  if (f >= static_cast<int>(factors_.size())) factors_.resize(f + 1);
  FactorState& factor = factors_[f];
  factor.variables = variables;
  factor.order = 1;
  for (int v : variables) {
    factor.order += variables_[v].dim;
    touch(variables_[v].clique);
  }
  factor.points = points;
  const std::size_t size = factor.size();
  new_factors_.all.push_back(f);
  factor.hessian = hessians_.allocate(size);
  factor.clique = -1;
  factor.alive = true;
  factor.saved = epoch_;
  std::fill_n(hessians_.at(factor.hessian), size, 0.0);
  return f;
}

void BayesTree::remove_factor(int f) {
  touch(factors_[f].clique);
  removed_factors_.all.push_back(f);
  factors_[f].alive = false;
}

double* BayesTree::hessian(int f) {
  FactorState& factor = factors_[f];
  double* h = hessians_.at(factor.hessian);
  touch(factor.clique);
  if (factor.saved != epoch_) {
    saved_hessians_.save(f, h, factor.size());
    factor.saved = epoch_;
  }
  return h;
}

void BayesTree::save_delta(int v) {
  VariableState& variable = variables_[v];
  if (variable.saved == epoch_) return;
  saved_deltas_.save(v, deltas_.at(variable.delta), variable.dim);
  variable.saved = epoch_;
}

/// Notes what a clique sees, and its motion, before they change.
void BayesTree::save_seen(int c) {
  Clique& clique = cliques_[c];
  if (clique.saved == epoch_ || clique.born == epoch_) return;
  saved_seen_.save(c, clique.seen(), clique.seen_size());
  clique.saved = epoch_;
}

/// What moves with the map sees what it has seen: its motion is all that changes.
void BayesTree::save_motion(int c) {
  Clique& clique = cliques_[c];
  if (clique.saved == epoch_ || clique.saved_motion == epoch_ || clique.born == epoch_) return;
  saved_seen_.save(~c, clique.motion(), kMotionSize);
  clique.saved_motion = epoch_;
}

void BayesTree::reset_delta(int v) {
  touch(variables_[v].clique);
  save_delta(v);
  std::fill_n(deltas_.at(variables_[v].delta), variables_[v].dim, 0.0);
}

void BayesTree::set_delta(int v, const double* step) {
  save_delta(v);
  std::copy_n(step, variables_[v].dim, deltas_.at(variables_[v].delta));
  const int c = variables_[v].clique;
  if (cliques_[c].pending) return;
  pending_.push_back(c);
  base_.pending.reserve(pending_.capacity());
  cliques_[c].pending = true;
}

void BayesTree::set_delta(int v, const Charts& charts) {
  const Clique& clique = cliques_[variables_[v].clique];
  view_.resize(clique.order);
  charts.see(clique.variables, 0, clique.chart(), view_.data());
  const double* step = view_.data();
  for (const int* own = clique.variables.data(); *own != v; ++own) step += variables_[*own].dim;
  set_delta(v, std::vector<double>(step, step + variables_[v].dim).data());
}

void BayesTree::touch(int clique) {
  if (clique >= 0) touched_.push_back(clique);
}

int BayesTree::new_clique() {
  const int c = clique_numbers_.take();
  if (c >= static_cast<int>(cliques_.size())) cliques_.resize(c + 1);
  born_.push_back(c);
  cliques_[c].born = epoch_;
  ++clique_count_;
  return c;
}

/// Frees a clique, whose number may then be used again.
void BayesTree::free_clique(int c) noexcept {
  Clique& clique = cliques_[c];
  clique.storage = {};
  clique.parent = -1;
  clique.children.clear();
  clique.variables.clear();
  clique.frontals = 0;
  clique.factors.clear();
  clique.detached = false;
  clique.pending = false;
  clique.free = false;
  clique.charted = false;
  clique.born = 0;
  clique.saved = clique.saved_motion = 0;
  clique_numbers_.give(c);
  --clique_count_;
}

void BayesTree::release_factor(int f) {
  const FactorState& factor = factors_[f];
  hessians_.release(factor.hessian, factor.size());
}

void BayesTree::commit() noexcept {
  for (int c : retired_) free_clique(c);
  for (int f : removed_factors_.all) {
    release_factor(f);
    factor_numbers_.give(f);
  }
  for (int v : removed_variables_.all) {
    deltas_.release(variables_[v].delta, variables_[v].dim);
    variables_[v] = {};
  }
  start_epoch();
}

void BayesTree::start_epoch() noexcept {
  ++epoch_;
  factor_numbers_.commit();
  clique_numbers_.commit();
  base_.fresh = fresh_;
  base_.pending = pending_;
  base_.epoch = epoch_;
  for (Changes* changes :
       {&new_variables_, &removed_variables_, &new_factors_, &removed_factors_}) {
    changes->all.clear();
    changes->pending = 0;
  }
  touched_.clear();
  detached_.clear();
  affected_.clear();
  retired_.clear();
  born_.clear();
  saved_hessians_.clear();
  saved_deltas_.clear();
  saved_seen_.clear();
}

/// Restores a clique that was replaced.
void BayesTree::reinstate(int c) {
  Clique& clique = cliques_[c];
  clique.detached = false;
  for (int k = 0; k < clique.frontals; ++k) variables_[clique.variables[k]].clique = c;
  for (int f : clique.factors) factors_[f].clique = c;
  for (int child : clique.children) cliques_[child].parent = c;
}

BayesTree::Mark BayesTree::mark() {
  Mark mark;
  mark.new_variables = new_variables_.all.size();
  mark.removed_variables = removed_variables_.all.size();
  mark.new_factors = new_factors_.all.size();
  mark.removed_factors = removed_factors_.all.size();
  mark.retired = retired_.size();
  mark.born = born_.size();
  mark.hessians = saved_hessians_.ids.size();
  mark.deltas = saved_deltas_.ids.size();
  mark.seen = saved_seen_.ids.size();
  mark.factor_numbers = factor_numbers_.mark();
  mark.clique_numbers = clique_numbers_.mark();
  mark.fresh = fresh_;
  mark.pending = pending_;
  mark.epoch = ++epoch_;
  return mark;
}

/// Writes back what has been overwritten since a mark, while all of it is still there.
void BayesTree::restore_numbers(const Mark& mark) noexcept {
  saved_hessians_.restore(
      mark.hessians, [&](int f) { return factors_[f].size(); },
      [&](int f) { return hessians_.at(factors_[f].hessian); });
  saved_deltas_.restore(
      mark.deltas, [&](int v) { return static_cast<std::size_t>(variables_[v].dim); },
      [&](int v) { return deltas_.at(variables_[v].delta); });
  saved_seen_.restore(
      mark.seen, [&](int c) { return c < 0 ? kMotionSize : cliques_[c].seen_size(); },
      [&](int c) { return c < 0 ? cliques_[~c].motion() : cliques_[c].seen(); });
}

void BayesTree::roll_back(const Mark& mark) noexcept {
  reset_scratch();
  restore_numbers(mark);
  for (std::size_t i = mark.born; i < born_.size(); ++i) {
    if (cliques_[born_[i]].born >= mark.epoch) free_clique(born_[i]);
  }
  for (std::size_t i = mark.retired; i < retired_.size(); ++i) reinstate(retired_[i]);
  for (int c : detached_) reinstate(c);  // by an interrupted elimination
  for (std::size_t i = mark.removed_factors; i < removed_factors_.all.size(); ++i) {
    factors_[removed_factors_.all[i]].alive = true;
  }
  for (std::size_t i = mark.new_factors; i < new_factors_.all.size(); ++i) {
    const int f = new_factors_.all[i];
    if (factors_[f].alive) release_factor(f);
    factors_[f].alive = false;
  }
  for (std::size_t i = mark.new_variables; i < new_variables_.all.size(); ++i) {
    const int v = new_variables_.all[i];
    if (variables_[v].dim > 0) deltas_.release(variables_[v].delta, variables_[v].dim);
    variables_[v] = {};
  }
  factor_numbers_.roll_back(mark.factor_numbers);
  clique_numbers_.roll_back(mark.clique_numbers);
  for (int c : pending_) cliques_[c].pending = false;
  fresh_ = mark.fresh;
  pending_ = mark.pending;
  for (int c : pending_) cliques_[c].pending = true;
  new_variables_.cut(mark.new_variables);
  removed_variables_.cut(mark.removed_variables);
  new_factors_.cut(mark.new_factors);
  removed_factors_.cut(mark.removed_factors);
  retired_.resize(mark.retired);
  born_.resize(mark.born);
  touched_.clear();
  detached_.clear();
  affected_.clear();
  ++epoch_;
}

/// Resets what an interrupted elimination or solution may have left.
void BayesTree::reset_scratch() {
  reset_local();
  reset_marks();
}

double BayesTree::Clique::log_pivots() const {
  double sum = 0.0;
  for (int j = 0; j < frontal_dim; ++j) {
    sum += std::log(columns()[static_cast<std::size_t>(j) * (order + 1)]);
  }
  return 2.0 * sum;
}

double BayesTree::log_determinant() const {
  double sum = 0.0;
  for (int c : top_down()) sum += cliques_[c].log_pivots();
  return sum;
}

double BayesTree::log_determinant_change() const {
  double sum = 0.0;
  std::vector<int> born = born_;  // a number that was reused occurs more than once
  sort_unique(born);
  for (int c : born) {
    if (cliques_[c].born >= base_.epoch) sum += cliques_[c].log_pivots();
  }
  for (int c : retired_) sum -= cliques_[c].log_pivots();
  return sum;
}

std::size_t BayesTree::bytes() const {
  std::size_t bytes = hessians_.bytes() + deltas_.bytes();
  bytes += cliques_.capacity() * sizeof(Clique) + factors_.capacity() * sizeof(FactorState) +
           variables_.capacity() * (sizeof(VariableState) + 2 * sizeof(int) + sizeof(double) + 1);
  for (const Clique& clique : cliques_) {
    bytes += clique.storage.bytes() + (clique.children.capacity() + clique.variables.capacity() +
                                       clique.factors.capacity()) *
                                          sizeof(int);
  }
  for (const FactorState& factor : factors_) bytes += factor.variables.capacity() * sizeof(int);
  return bytes;
}

}  // namespace hybrid
