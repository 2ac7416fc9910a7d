// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "libhybrid/smoother/terms.h"

namespace HYBRID_API hybrid {

/// Numbers of terms, each once, in the order in which they came. Beginning anew costs nothing.
class TermList {
 public:
  const std::vector<int>& get() const { return list_; }
  std::size_t size() const { return list_.size(); }

  /// Begins anew with the terms of some variables.
  void start(const std::vector<int>& slots, const Terms& terms) {
    list_.clear();
    ++now_;
    added_.resize(std::max(added_.size(), static_cast<std::size_t>(terms.count())));
    for (int slot : slots) {
      for (int t : terms.of_variable(slot)) add(t);
    }
  }
  bool contains(int t) const { return added_[t] == now_; }
  /// Adds another of the terms.
  void add(int t) {
    if (contains(t)) return;
    added_[t] = now_;
    list_.push_back(t);
  }
  void sort_from(std::size_t first) {
    std::sort(list_.begin() + static_cast<std::ptrdiff_t>(first), list_.end());
  }

 private:
  std::vector<int> list_;
  std::vector<unsigned> added_;  // by term: when it was last added
  unsigned now_ = 0;
};

}  // namespace hybrid
