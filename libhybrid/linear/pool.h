// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <new>
#include <vector>

#include "libhybrid/linear/block.h"

namespace HYBRID_API hybrid {

/// Short arrays of doubles in large blocks of memory, by number; freed arrays are reused by others
/// of the same length. Numbers and pointers stay valid when the pool grows.
class Pool {
 public:
  std::size_t allocate(std::size_t length) {
    if (length < free_.size() && !free_[length].empty()) {
      const std::size_t number = free_[length].back();
      free_[length].pop_back();
      return number;
    }
    if (blocks_.empty() || used_ + length > kBlock) {  // a longer array has a block of its own
      blocks_.emplace_back(length < kBlock ? kBlock : length);
      bytes_ += blocks_.back().bytes();
      used_ = 0;
    }
    const std::size_t number = (blocks_.size() - 1) * kBlock + used_;
    used_ += length;
    return number;
  }
  /// Frees an array for reuse; without memory for that, its place is never used again.
  void release(std::size_t number, std::size_t length) noexcept {
    try {
      if (length >= free_.size()) free_.resize(length + 1);
      free_[length].push_back(number);
    } catch (const std::bad_alloc&) {  // NOLINT(bugprone-empty-catch)
    }
  }

  double* at(std::size_t number) { return blocks_[number / kBlock].data() + number % kBlock; }
  const double* at(std::size_t number) const {
    return blocks_[number / kBlock].data() + number % kBlock;
  }
  std::size_t bytes() const { return bytes_; }

 private:
  static constexpr std::size_t kBlock = 4096;

  std::vector<Block> blocks_;
  std::size_t used_ = 0;  // of the last block
  std::size_t bytes_ = 0;
  std::vector<std::vector<std::size_t>> free_;
};

}  // namespace hybrid
