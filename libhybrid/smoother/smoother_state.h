// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/smoother/continuous_half.h"
#include "libhybrid/smoother/discrete_half.h"

namespace HYBRID_API hybrid {

/// A graph whose changes since the last `commit`, or since a mark after it, can be rolled back, at
/// the cost of what changed. Each factor has a number, of the term or table that it is elsewhere.
class JournaledGraph {
 public:
  const HybridGraph& get() const { return graph_; }
  const HybridGraph* operator->() const { return &graph_; }

  /// Adds a factor of any kind.
  template <class Factor>
  Handle add(Factor factor) {
    changes_.emplace_back();
    Change& change = changes_.back();
    change.added = true;
    const Handle handle = change.factor.handle = graph_.add(std::move(factor));
    std::vector<int>& numbers = numbers_[static_cast<int>(handle.kind)];
    if (handle.index >= numbers.size()) numbers.resize(handle.index + 1);
    change.number = numbers[handle.index];
    return handle;
  }
  void remove(Handle handle) {
    changes_.emplace_back();
    changes_.back().factor = graph_.remove(handle);
  }

  int number(Handle handle) const { return numbers_[static_cast<int>(handle.kind)][handle.index]; }
  void set_number(Handle handle, int number) {
    numbers_[static_cast<int>(handle.kind)][handle.index] = number;
  }

  void commit() noexcept { changes_.clear(); }
  /// The present state, to go back to until the next commit or the roll-back to an earlier one.
  std::size_t mark() const { return changes_.size(); }
  void roll_back(std::size_t mark = 0) noexcept {
    for (; changes_.size() > mark; changes_.pop_back()) undo(changes_.back());
  }

 private:
  struct Change {
    HybridGraph::Removed factor;
    bool added = false;
    int number = -1;  // that the place of an added factor had before
  };

  void undo(Change& change) noexcept {
    const Handle handle = change.factor.handle;
    if (!handle.valid()) return;  // memory was short when it was to be done
    if (!change.added) {
      graph_.put_back(std::move(change.factor));
    } else if (graph_.contains(handle)) {
      std::vector<int>& numbers = numbers_[static_cast<int>(handle.kind)];
      if (handle.index < numbers.size()) numbers[handle.index] = change.number;
      graph_.remove(handle);
    }
  }

  HybridGraph graph_;
  std::array<std::vector<int>, 3> numbers_;  // by kind and index of handle
  std::vector<Change> changes_;              // since the last commit
};

/// What the smoother knows: a graph, and its factors in both halves. They change together, and
/// changes are kept or taken back together. Of transactions and marks see IncrementalSmoother.
class SmootherState {
 public:
  const HybridGraph& graph() const { return graph_.get(); }
  const ContinuousHalf& continuous() const { return continuous_; }
  ContinuousHalf& continuous() { return continuous_; }
  const DiscreteHalf& discrete() const { return discrete_; }
  DiscreteHalf& discrete() { return discrete_; }
  Given given() const { return {graph(), discrete_.assignment()}; }

  /// Throws Error for anything in a change that would leave the graph inconsistent.
  void check(const Delta& delta) const;
  /// Applies a change; new hybrid factors do not enter the tree yet.
  AddedHandles stage(const Delta& delta);
  /// Brings new factors into the tree, with the components that the assignment chooses.
  void enter_tree(const AddedHandles& handles);
  /// Gives a discrete variable a value, and the hybrid factors about it their components.
  void choose_components(Key key);
  /// Brings the tables of hybrid factors up to date whose variables have moved.
  void refresh_tables();
  /// Variables of either kind that came, or whose estimate may have changed, since the last commit.
  std::vector<Key> changed() const;

  void begin();
  bool in_transaction() const { return in_transaction_; }
  /// Called before a change.
  void start_change();
  /// Makes what has changed permanent; so many of the newest poses stay near the root.
  void commit(int recent) noexcept;
  void roll_back() noexcept;
  std::size_t mark();
  void release(std::size_t mark);
  void roll_back_to(std::size_t mark) noexcept;
  /// Takes back what came since the newest mark, or all.
  void undo_failed() noexcept { marks_.empty() ? roll_back() : roll_back_to(marks_.size()); }

 private:
  struct Mark {
    std::size_t graph = 0;
    ContinuousHalf::Mark continuous;
    DiscreteHalf::Mark discrete;
  };

  void remove_factor(Handle handle);
  void end_change() noexcept;

  JournaledGraph graph_;  // with the numbers of terms, or of tables of discrete factors
  ContinuousHalf continuous_;
  DiscreteHalf discrete_;
  bool in_transaction_ = false;
  bool changing_ = false;  // since the last commit
  std::vector<Mark> marks_;
};

}  // namespace hybrid
