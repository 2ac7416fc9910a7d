// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "libhybrid/hybrid/graph.h"

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

}  // namespace hybrid
