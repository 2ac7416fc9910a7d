// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// How a change enters the smoother, becomes permanent or is taken back.
#include <algorithm>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/smoother/detail/pose_charts.h"
#include "libhybrid/smoother/incremental.h"

namespace hybrid {
namespace {

template <class T>
T& at_index(std::vector<T>& list, std::size_t index) {
  if (index >= list.size()) list.resize(index + 1);
  return list[index];
}

}  // namespace

void IncrementalSmoother::begin() {
  if (in_transaction_) throw Error("the smoother is in a transaction already");
  start_change();
  in_transaction_ = true;
}

/// Notes what small things are before the first change since the last commit.
void IncrementalSmoother::start_change() {
  if (changing_) return;
  committed_ = small();
  changing_ = true;
}

IncrementalSmoother::Small IncrementalSmoother::small() const {
  return {term_cost_, term_constant_, off_,       stale_,         last_,
          map_kind_,  recent_,        kept_last_, weak_left_out_, couple_weak_};
}

void IncrementalSmoother::commit() {
  if (!in_transaction_) throw Error("the smoother is in no transaction; was an update refused?");
  make_permanent();
}

void IncrementalSmoother::roll_back() {
  if (in_transaction_) take_back();
}

std::size_t IncrementalSmoother::mark() {
  if (!in_transaction_) throw Error("a mark is set within a transaction, and there is none");
  marks_.reserve(marks_.size() + 1);
  marks_.push_back({small(), tree_.mark(), terms_.mark(), discrete_.mark(), estimate_.mark(),
                    graph_changes_.size(), lost_.size()});
  return marks_.size();
}

void IncrementalSmoother::release(std::size_t mark) {
  if (marks_.size() < mark) throw Error("the mark is gone; was an update refused?");
  marks_.erase(marks_.begin() + static_cast<std::ptrdiff_t>(mark) - 1, marks_.end());
}

void IncrementalSmoother::roll_back_to(std::size_t mark) noexcept {
  if (marks_.size() < mark) return;
  Mark& to = marks_[mark - 1];
  undo_graph_changes(to.graph_changes);
  tree_.roll_back(to.tree);
  terms_.roll_back(to.terms);
  discrete_.roll_back(to.discrete);
  estimate_.roll_back(to.values);
  restore(std::move(to.small));
  lost_.erase(lost_.begin() + static_cast<std::ptrdiff_t>(to.lost), lost_.end());
  marks_.erase(marks_.begin() + static_cast<std::ptrdiff_t>(mark) - 1, marks_.end());
}

/// Applies a change to the graph; new hybrid terms do not enter the tree yet.
void IncrementalSmoother::stage(const Delta& delta, UpdateReport& report) {
  for (Handle handle : delta.remove) remove_factor(handle);
  for (Key key : delta.remove_values) {
    tree_.remove_variable(values().slot(key));
    estimate_.remove(key);
  }
  for (Key key : delta.values.keys()) add_variable(key, delta.values);
  for (const ContinuousFactorPtr& factor : delta.continuous) {
    Term term;
    term.continuous = factor;
    term.handle = add_to_graph(factor);
    add_term(std::move(term), report);
  }
  for (const Table& table : delta.discrete) {
    const Handle handle = add_to_graph(table);
    report.handles.discrete.push_back(handle);
    const int f = number_of(handle) = discrete_.add(table.keys(), -1, delta.assignment);
    discrete_.set_tables(f, {table});
  }
  for (const HybridFactorPtr& factor : delta.hybrid) {
    const int f = discrete_.add(factor->discrete_keys(), -1, delta.assignment);
    Term term;
    term.hybrid = factor;
    term.handle = add_to_graph(factor);
    const int t = add_term(std::move(term), report);
    discrete_.set_owner(f, t);
    table_of_term_[t] = f;
    stale_.push_back(t);
  }
}

void IncrementalSmoother::remove_factor(Handle handle) {
  if (handle.kind == FactorKind::kDiscrete) {
    discrete_.remove(number_of(handle));
  } else {
    const int t = term_of(handle);
    if (table_of_term_[t] >= 0) discrete_.remove(table_of_term_[t]);
    term_cost_.subtract(terms_[t].cost);
    term_constant_.subtract(terms_[t].constant);
    leave_tree(t);
    terms_.remove(t);
  }
  graph_changes_.push_back({{}, false});
  graph_changes_.back().factor = graph_.remove(handle);
}

/// With the first landmark the steps of poses are along other lines, so that all linear models are
/// made again.
void IncrementalSmoother::note_map_kind(VariableType type) {
  if (is_pose(type) && map_kind_.pose == VariableKind::kVector) map_kind_.pose = type.kind;
  const bool is_point = type.kind == VariableKind::kVector && (type.dim == 2 || type.dim == 3);
  if (!is_point || map_kind_.has_points) return;
  map_kind_.has_points = true;
  std::vector<int> all(terms_.count());
  std::iota(all.begin(), all.end(), 0);
  UpdateReport uncounted;
  make_models_again(all, uncounted);
}

void IncrementalSmoother::add_variable(Key key, const Values& initial) {
  const VariableType type = initial.type(key);
  estimate_.insert(key, type, initial.data(key));
  const int slot = values().slot(key);
  note_map_kind(type);
  tree_.add_variable(slot, type.dim);
  terms_.reserve_variable(slot);
  if (is_pose(type)) recent_.push_back(key);
}

template <class Factor>
Handle IncrementalSmoother::add_to_graph(Factor factor) {
  graph_changes_.push_back({{}, true});
  const Handle handle = graph_changes_.back().factor.handle = graph_.add(std::move(factor));
  int& number = at_index(numbers_[static_cast<int>(handle.kind)], handle.index);
  graph_changes_.back().number = number;
  return handle;
}

/// Returns the number of the term.
int IncrementalSmoother::add_term(Term term, UpdateReport& report) {
  std::vector<const double*> x;
  for (Key key : term.keys()) {
    term.slots.push_back(values().slot(key));
    x.push_back(values().data(term.slots.back()));
  }
  term.holds = term.hybrid != nullptr ? !moves_with_map(map_kind_.pose, *term.hybrid, x.data())
                                      : !moves_with_map(map_kind_.pose, *term.continuous, x.data());
  const Handle handle = term.handle;
  (term.hybrid ? report.handles.hybrid : report.handles.continuous).push_back(handle);
  const int t = number_of(handle) = terms_.add(std::move(term));
  at_index(term_stamp_, t) = 0;
  at_index(table_of_term_, t) = -1;
  Term& added = terms_.edit(t);
  if (added.hybrid != nullptr) {
    added.choose(added.hybrid->given(assignment()));
  } else {
    Component own;
    own.factor = added.continuous.get();
    added.choose(own);
  }
  added.cost = evaluate(added, values());
  term_cost_.add(added.cost);
  term_constant_.add(added.constant);
  if (added.hybrid == nullptr) enter_tree(t);
  // What the tree has made of its variables does not know that they are held.
  if (added.holds && added.tree_factor < 0) {
    for (int slot : added.slots) tree_.eliminate_again(slot);
  }
  return t;
}

/// Enters new hybrid terms with the components that the discrete half-step has chosen, so that a
/// measurement rejected at once never touches the tree; and lists what to eliminate last.
void IncrementalSmoother::enter_new_terms(const AddedHandles& handles) {
  last_.clear();
  for (const std::vector<Handle>* list : {&handles.continuous, &handles.hybrid}) {
    for (Handle handle : *list) {
      const int t = term_of(handle);
      if (terms_[t].tree_factor < 0) enter_tree(t);
      if (terms_[t].tree_factor < 0) continue;
      last_.insert(last_.end(), terms_[t].slots.begin(), terms_[t].slots.end());
    }
  }
  for (Key key : recent_) {
    if (values().contains(key) && !estimate_.is_removed(key)) last_.push_back(values().slot(key));
  }
}

void IncrementalSmoother::make_permanent() noexcept {
  tree_.commit();
  terms_.commit();
  discrete_.commit();
  estimate_.commit();
  graph_changes_.clear();
  const auto recent = static_cast<std::size_t>(std::max(options_.recent, 0));
  if (recent_.size() > recent) recent_.erase(recent_.begin(), recent_.end() - recent);
  end_change();
}

void IncrementalSmoother::end_change() noexcept {
  lost_.clear();
  marks_.clear();
  changing_ = false;
  in_transaction_ = false;
}

/// Those from a number on, the last first.
void IncrementalSmoother::undo_graph_changes(std::size_t first) noexcept {
  for (; graph_changes_.size() > first; graph_changes_.pop_back()) {
    GraphChange& change = graph_changes_.back();
    if (!change.factor.handle.valid()) continue;  // memory was short when it was to be done
    if (!change.added) {
      graph_.put_back(std::move(change.factor));
    } else if (const Handle handle = change.factor.handle; graph_.contains(handle)) {
      std::vector<int>& numbers = numbers_[static_cast<int>(handle.kind)];
      if (handle.index < numbers.size()) numbers[handle.index] = change.number;
      graph_.remove(handle);
    }
  }
}

void IncrementalSmoother::restore(Small&& before) noexcept {
  for (int slot : damped_) damping_factor_[slot] = -1;
  damped_.clear();
  term_cost_ = before.term_cost;
  term_constant_ = before.term_constant;
  off_ = std::move(before.off);
  map_kind_ = before.map_kind;
  stale_ = std::move(before.stale);
  last_ = std::move(before.last);
  recent_ = std::move(before.recent);
  kept_last_ = std::move(before.kept_last);
  weak_left_out_ = before.weak_left_out;
  couple_weak_ = before.couple_weak;
  errors_.clear();
}

/// Takes back what came since the newest mark, or all.
void IncrementalSmoother::undo_failed() noexcept {
  marks_.empty() ? take_back() : roll_back_to(marks_.size());
}

void IncrementalSmoother::take_back() noexcept {
  if (!changing_) return;
  undo_graph_changes(0);
  tree_.roll_back();
  terms_.roll_back();
  discrete_.roll_back();
  estimate_.roll_back();
  restore(std::move(committed_));
  end_change();
}

std::vector<Handle> IncrementalSmoother::factors_of(Key key) const {
  std::vector<Handle> handles;
  for (int t : terms_.of_variable(values().slot(key))) {
    if (terms_[t].alive) handles.push_back(terms_[t].handle);
  }
  return handles;
}

IncrementalSmoother::Memory IncrementalSmoother::memory() const {
  Memory memory;
  memory.bytes = tree_.bytes() + terms_.bytes() + discrete_.bytes() + estimate_->bytes();
  if (!values().empty()) memory.bytes_per_variable = double(memory.bytes) / double(values().size());
  return memory;
}

}  // namespace hybrid
