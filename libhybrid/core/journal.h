// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Arrays as they were before they changed, so that changes since the last `commit`, or since a
/// mark after it, can be rolled back, at the cost of their extent alone. An array has a number and
/// keeps the epoch in which it was saved last, or made; between two marks it is saved once.
template <class T>
class Journal {
 public:
  struct Entry {
    int number;
    std::size_t first;  ///< of its elements among those of all entries
  };

  /// Each mark, commit and roll-back begins another.
  unsigned epoch() const { return epoch_; }
  const std::vector<Entry>& entries() const { return entries_; }

  /// To be called before an array changes.
  void save(int number, unsigned& saved, const T* array, std::size_t size = 1) {
    if (saved == epoch_) return;
    // Both or neither where memory is short: what is last is restored first.
    if (entries_.size() == entries_.capacity()) entries_.reserve(2 * entries_.size() + 1);
    saved_.insert(saved_.end(), array, array + size);
    entries_.push_back({number, saved_.size() - size});
    saved = epoch_;
  }

  void commit() noexcept {
    entries_.clear();
    saved_.clear();
    ++epoch_;
  }
  std::size_t mark() {
    ++epoch_;
    return entries_.size();
  }
  /// Writes what was saved since a mark back to place(number), the last first.
  template <class Place>
  void roll_back(std::size_t mark, const Place& place) noexcept {
    for (; entries_.size() > mark; entries_.pop_back()) {
      const auto first = saved_.begin() + static_cast<std::ptrdiff_t>(entries_.back().first);
      std::move(first, saved_.end(), place(entries_.back().number));
      saved_.erase(first, saved_.end());
    }
    ++epoch_;
  }

 private:
  std::vector<Entry> entries_;
  std::vector<T> saved_;
  unsigned epoch_ = 1;
};

}  // namespace hybrid
