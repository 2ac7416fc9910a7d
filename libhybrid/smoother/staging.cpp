// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// How an update is checked, staged, committed or taken back.
#include <algorithm>
#include <cmath>
#include <string>
#include <unordered_set>
#include <utility>

#include "libhybrid/smoother/incremental.h"

namespace hybrid {
namespace {

bool is_pose(VariableKind kind) {
  return kind == VariableKind::kSE2 || kind == VariableKind::kSE3;
}

template <class T>
T& at_index(std::vector<T>& list, std::size_t index) {
  if (index >= list.size()) list.resize(index + 1);
  return list[index];
}

}  // namespace

void IncrementalSmoother::add_term(Term term, UpdateReport& report) {
  for (Key key : term.keys()) term.slots.push_back(theta_.slot(key));
  report.handles.push_back(term.handle);
  const int t = terms_.add(std::move(term));
  at_index(term_stamp_, t) = 0;
  Term& added = terms_[t];
  int& table = at_index(table_of_term_, t);
  table = -1;
  if (added.hybrid != nullptr) {
    at_index(term_of_hybrid_, added.handle.index) = t;
    added.component = added.hybrid->given(assignment());
  } else {
    at_index(term_of_continuous_, added.handle.index) = t;
    added.component.factor = added.continuous.get();
  }
  added.cost = evaluate(added, estimate_);
  term_cost_.add(added.cost);
  term_constant_.add(constant_of(added.component));
  if (added.hybrid == nullptr) enter_tree(t);
  undo_.push_back([this, t] {
    graph_.remove(terms_[t].handle);
    term_cost_.subtract(terms_[t].cost);
    term_constant_.subtract(constant_of(terms_[t].component));
    terms_.remove(t);
  });
}

/// Adds what is new and sets aside what goes. Everything here can be taken back by `undo`.
IncrementalSmoother::Staged IncrementalSmoother::stage(const Delta& delta, UpdateReport& report) {
  Staged staged;
  undo_.clear();
  stage_removals(delta, staged);
  for (Key key : delta.values.keys()) {
    const VariableType type = delta.values.type(key);
    theta_.insert(key, type, delta.values.data(key));
    estimate_.insert(key, type, delta.values.data(key));
    const int slot = theta_.slot(key);
    tree_.add_variable(slot, type.dim);
    terms_.reserve_variable(slot);
    if (is_pose(type.kind)) recent_.push_back(key);
    undo_.push_back([this, key, pose = is_pose(type.kind)] {
      theta_.erase(key);
      estimate_.erase(key);
      if (pose) recent_.pop_back();
    });
  }
  for (const ContinuousFactorPtr& factor : delta.continuous) {
    Term term;
    term.continuous = factor;
    term.handle = graph_.add(factor);
    add_term(std::move(term), report);
  }
  for (const Table& table : delta.discrete) {
    const Handle handle = graph_.add(table);
    report.handles.push_back(handle);
    const int f = discrete_.add(table.keys(), -1, delta.assignment);
    at_index(table_of_discrete_, handle.index) = f;
    discrete_.set_tables(f, {table});
    undo_.push_back([this, f, handle] {
      discrete_.remove(f);
      graph_.remove(handle);
    });
  }
  for (const HybridFactorPtr& factor : delta.hybrid) {
    Term term;
    term.hybrid = factor;
    const int f = discrete_.add(factor->discrete_keys(), terms_.next(), delta.assignment);
    undo_.push_back([this, f] { discrete_.remove(f); });
    term.handle = graph_.add(factor);
    add_term(std::move(term), report);
    const int t = term_of_hybrid_[report.handles.back().index];
    table_of_term_[t] = f;
    stale_.push_back(t);
  }
  return staged;
}

/// Enters new hybrid terms with the components that the discrete half-step has chosen, so that a
/// measurement rejected at once never touches the tree; and lists what to eliminate last.
void IncrementalSmoother::enter_new_terms(const std::vector<Handle>& handles) {
  last_.clear();
  for (Handle handle : handles) {
    if (handle.kind == FactorKind::kDiscrete) continue;
    const int t = handle.kind == FactorKind::kContinuous ? term_of_continuous_[handle.index]
                                                         : term_of_hybrid_[handle.index];
    if (terms_[t].tree_factor < 0) enter_tree(t);
    if (terms_[t].tree_factor < 0) continue;
    last_.insert(last_.end(), terms_[t].slots.begin(), terms_[t].slots.end());
  }
  for (Key key : recent_) {
    if (theta_.contains(key)) last_.push_back(theta_.slot(key));
  }
}

void IncrementalSmoother::stage_removals(const Delta& delta, Staged& staged) {
  const auto set_tables_aside = [this](int f) {
    undo_.push_back([this, f, tables = discrete_.tables(f)] { discrete_.set_tables(f, tables); });
    discrete_.set_tables(f, {});
  };
  for (Handle handle : delta.remove) {
    staged.handles.push_back(handle);
    if (handle.kind == FactorKind::kDiscrete) {
      staged.tables.push_back(table_of_discrete_[handle.index]);
      set_tables_aside(table_of_discrete_[handle.index]);
      continue;
    }
    const int t = handle.kind == FactorKind::kContinuous ? term_of_continuous_[handle.index]
                                                         : term_of_hybrid_[handle.index];
    staged.terms.push_back(t);
    if (table_of_term_[t] >= 0) {
      staged.tables.push_back(table_of_term_[t]);
      set_tables_aside(table_of_term_[t]);
    }
    Term& term = terms_[t];
    term.alive = false;
    term_cost_.subtract(term.cost);
    term_constant_.subtract(constant_of(term.component));
    undo_.push_back([this, t, tree_factor = term.tree_factor, pulls = term.pulls] {
      terms_[t].alive = true;
      terms_[t].tree_factor = tree_factor;
      terms_[t].pulls = pulls;
      term_cost_.add(terms_[t].cost);
      term_constant_.add(constant_of(terms_[t].component));
    });
    leave_tree(t);
  }
  for (Key key : delta.remove_values) {
    staged.values.push_back(key);
    tree_.remove_variable(theta_.slot(key));
  }
}

void IncrementalSmoother::commit(const Staged& staged) {
  undo_.clear();
  for (int t : staged.terms) terms_.remove(t);
  for (int f : staged.tables) discrete_.remove(f);
  for (Handle handle : staged.handles) graph_.remove(handle);
  for (Key key : staged.values) {
    theta_.erase(key);
    estimate_.erase(key);
  }
  while (static_cast<int>(recent_.size()) > options_.recent) recent_.pop_front();
}

void IncrementalSmoother::undo() {
  for (auto action = undo_.rbegin(); action != undo_.rend(); ++action) (*action)();
  undo_.clear();
}

std::vector<Handle> IncrementalSmoother::factors_of(Key key) const {
  std::vector<Handle> handles;
  for (int t : terms_.of_variable(estimate_.slot(key))) handles.push_back(terms_[t].handle);
  return handles;
}

IncrementalSmoother::Memory IncrementalSmoother::memory() const {
  Memory memory;
  memory.bytes =
      tree_.bytes() + terms_.bytes() + discrete_.bytes() + theta_.bytes() + estimate_.bytes();
  if (!estimate_.empty())
    memory.bytes_per_variable = double(memory.bytes) / double(estimate_.size());
  return memory;
}

}  // namespace hybrid
