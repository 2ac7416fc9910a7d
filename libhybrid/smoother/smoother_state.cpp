// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/smoother_state.h"

#include <utility>

#include "libhybrid/smoother/detail/check.h"

namespace hybrid {

void SmootherState::check(const Delta& delta) const {
  hybrid::check(delta, graph(), continuous_.estimate(), continuous_.terms(), discrete_);
}

AddedHandles SmootherState::stage(const Delta& delta) {
  AddedHandles added;
  for (Handle handle : delta.remove) remove_factor(handle);
  for (Key key : delta.remove_values) continuous_.remove_variable(key);
  for (Key key : delta.values.keys()) continuous_.add_variable(key, delta.values);
  for (const ContinuousFactorPtr& factor : delta.continuous) {
    Term term;
    term.continuous = factor;
    term.handle = graph_.add(factor);
    added.continuous.push_back(term.handle);
    Component own;
    own.factor = factor.get();
    term.choose(own);
    graph_.set_number(term.handle, continuous_.add_term(term));
  }
  for (const Table& table : delta.discrete) {
    const Handle handle = graph_.add(table);
    added.discrete.push_back(handle);
    const int f = discrete_.add(table.keys(), -1, delta.assignment);
    graph_.set_number(handle, f);
    discrete_.set_tables(f, {table});
  }
  for (const HybridFactorPtr& factor : delta.hybrid) {
    Term term;
    term.hybrid = factor;
    term.table = discrete_.add(factor->discrete_keys(), -1, delta.assignment);
    term.handle = graph_.add(factor);
    added.hybrid.push_back(term.handle);
    term.choose(factor->given(discrete_.assignment()));
    const int t = continuous_.add_term(term);
    graph_.set_number(term.handle, t);
    discrete_.set_owner(term.table, t);
  }
  return added;
}

void SmootherState::remove_factor(Handle handle) {
  const int number = graph_.number(handle);
  if (handle.kind == FactorKind::kDiscrete) {
    discrete_.remove(number);
  } else {
    const int table = continuous_.terms()[number].table;
    if (table >= 0) discrete_.remove(table);
    continuous_.remove_term(number);
  }
  graph_.remove(handle);
}

void SmootherState::enter_tree(const AddedHandles& handles) {
  std::vector<int> terms;
  for (Handle handle : handles.continuous) terms.push_back(graph_.number(handle));
  for (Handle handle : handles.hybrid) terms.push_back(graph_.number(handle));
  continuous_.enter_new(terms);
}

void SmootherState::choose_components(Key key) {
  for (int f : discrete_.factors_of(key)) {
    const int t = discrete_.owner(f);
    if (t < 0 || !continuous_.terms()[t].alive) continue;
    continuous_.choose(t, continuous_.terms()[t].hybrid->given(discrete_.assignment()));
  }
}

void SmootherState::refresh_tables() {
  std::vector<const double*> x;
  for (int t : continuous_.take_stale()) {
    if (t >= continuous_.terms().count()) continue;
    const Term& term = continuous_.terms()[t];
    if (!term.alive) continue;
    x.clear();
    for (int slot : term.slots) x.push_back(continuous_.values().data(slot));
    discrete_.set_tables(term.table, term.hybrid->given(x.data()));
  }
}

std::vector<Key> SmootherState::changed() const {
  const JournaledValues& estimate = continuous_.estimate();
  std::vector<Key> keys;
  const auto add = [&](Key key) {
    if (!estimate.is_removed(key)) keys.push_back(key);
  };
  for (int slot : estimate.edited()) add(estimate->key(slot));
  for (Key key : estimate.inserted()) add(key);
  discrete_.list_changed(keys);
  return keys;
}

void SmootherState::begin() {
  if (in_transaction_) throw Error("the smoother is in a transaction already");
  start_change();
  in_transaction_ = true;
}

std::size_t SmootherState::mark() {
  if (!in_transaction_) throw Error("a mark is set within a transaction, and there is none");
  marks_.reserve(marks_.size() + 1);
  marks_.push_back({graph_.mark(), continuous_.mark(), discrete_.mark()});
  return marks_.size();
}

void SmootherState::release(std::size_t mark) {
  if (marks_.size() < mark) throw Error("the mark is gone; was an update refused?");
  marks_.erase(marks_.begin() + static_cast<std::ptrdiff_t>(mark) - 1, marks_.end());
}

void SmootherState::roll_back_to(std::size_t mark) noexcept {
  if (marks_.size() < mark) return;
  Mark& to = marks_[mark - 1];
  graph_.roll_back(to.graph);
  continuous_.roll_back(std::move(to.continuous));
  discrete_.roll_back(to.discrete);
  marks_.erase(marks_.begin() + static_cast<std::ptrdiff_t>(mark) - 1, marks_.end());
}

void SmootherState::start_change() {
  if (!changing_) continuous_.start_change();
  changing_ = true;
}

void SmootherState::commit(int recent) noexcept {
  graph_.commit();
  continuous_.commit(recent);
  discrete_.commit();
  end_change();
}

void SmootherState::roll_back() noexcept {
  if (!changing_) return;
  graph_.roll_back();
  continuous_.roll_back();
  discrete_.roll_back();
  end_change();
}

void SmootherState::end_change() noexcept {
  marks_.clear();
  changing_ = false;
  in_transaction_ = false;
}

}  // namespace hybrid
