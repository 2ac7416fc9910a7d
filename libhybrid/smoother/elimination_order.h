// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <utility>
#include <vector>

#include "libhybrid/smoother/journaled_values.h"

namespace HYBRID_API hybrid {

/// Which variables are eliminated last, near the root of the tree: those of the newest factors and
/// the newest poses, and behind them those that are to be kept last.
class EliminationOrder {
 public:
  void enter_pose(Key key) { recent_.push_back(key); }
  void keep_last(const std::vector<Key>& keys) { kept_ = keys; }

  /// Begins anew with the slots of the variables of new factors, or goes on with them where earlier
  /// ones are still to be eliminated; the newest poses follow.
  void start(const std::vector<int>& slots, bool goes_on, const JournaledValues& values) {
    if (!goes_on) last_.clear();
    last_.insert(last_.end(), slots.begin(), slots.end());
    for (Key key : recent_) {
      if (values->contains(key) && !values.is_removed(key)) last_.push_back(values->slot(key));
    }
  }
  /// Keeps the newest of the poses, so many.
  void forget(int poses) noexcept {
    const auto count = static_cast<std::size_t>(std::max(poses, 0));
    if (recent_.size() > count) recent_.erase(recent_.begin(), recent_.end() - count);
  }

  /// Slots of the last, as of the last start.
  const std::vector<int>& last() const { return last_; }
  /// Slots of those behind them.
  std::vector<int> behind(const Values& values) const {
    std::vector<int> slots;
    for (Key key : kept_) {
      if (values.contains(key)) slots.push_back(values.slot(key));
    }
    return slots;
  }

 private:
  std::vector<Key> recent_, kept_;
  std::vector<int> last_;
};

}  // namespace hybrid
