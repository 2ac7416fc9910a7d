// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <new>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Hands out the numbers 0, 1, ... and reuses those given back, the last one first. Changes since
/// the last `commit`, or since a mark after it, can be rolled back, at a cost that depends on their
/// number alone.
class FreeList {
 public:
  int take() {
    if (free_.empty()) {
      steps_.push_back(kNew);
      return count_++;
    }
    const int number = free_.back();
    steps_.push_back(number);
    free_.pop_back();
    return number;
  }
  /// Returns a number for reuse; without memory for that, the number is never used again.
  void give(int number) noexcept {
    const std::size_t steps = steps_.size();
    try {
      steps_.push_back(kGiven);
      free_.push_back(number);
    } catch (const std::bad_alloc&) {
      steps_.resize(steps);
    }
  }

  /// Numbers from 0 to count() - 1 are in use or free.
  int count() const { return count_; }

  void commit() noexcept { steps_.clear(); }
  std::size_t mark() const { return steps_.size(); }
  void roll_back(std::size_t mark = 0) noexcept {
    for (; steps_.size() > mark; steps_.pop_back()) {
      const int step = steps_.back();
      if (step == kNew) {
        --count_;
      } else if (step == kGiven) {
        free_.pop_back();
      } else {
        free_.push_back(step);  // into the room that it had before
      }
    }
  }

 private:
  static constexpr int kNew = -1, kGiven = -2;

  std::vector<int> free_;
  int count_ = 0;
  std::vector<int> steps_;  // since the last commit: numbers taken that were free, kNew, kGiven
};

}  // namespace hybrid
