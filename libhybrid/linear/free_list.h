// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <new>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Hands out the numbers 0, 1, ... and reuses those given back, the last one first. Changes since
/// the last `commit` can be rolled back, at a cost that depends on their number alone.
class FreeList {
 public:
  int take() {
    if (free_.empty()) return count_++;
    const int number = free_.back();
    if (free_.size() == kept_) {
      taken_.push_back(number);
      --kept_;
    }
    free_.pop_back();
    return number;
  }
  /// Returns a number for reuse; without memory for that, the number is never used again.
  void give(int number) noexcept {
    try {
      free_.push_back(number);
    } catch (const std::bad_alloc&) {  // NOLINT(bugprone-empty-catch)
    }
  }

  /// Numbers from 0 to count() - 1 are in use or free.
  int count() const { return count_; }

  void commit() {
    committed_count_ = count_;
    kept_ = free_.size();
    taken_.clear();
  }
  void roll_back() {
    count_ = committed_count_;
    free_.resize(kept_);
    free_.insert(free_.end(), taken_.rbegin(), taken_.rend());
    commit();
  }

 private:
  std::vector<int> free_;
  int count_ = 0;
  int committed_count_ = 0;
  std::size_t kept_ = 0;    // how many of `free_` have been there since the last commit
  std::vector<int> taken_;  // numbers that were free then and are taken, the last one first
};

}  // namespace hybrid
