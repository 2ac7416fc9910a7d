// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <new>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Arrays of T in one block of memory, by offset; freed arrays are reused by others of the same
/// length. Offsets stay valid, pointers do not, when the pool grows.
template <class T>
class Pool {
 public:
  std::size_t allocate(std::size_t length) {
    if (length < free_.size() && !free_[length].empty()) {
      const std::size_t offset = free_[length].back();
      free_[length].pop_back();
      return offset;
    }
    const std::size_t offset = data_.size();
    data_.resize(offset + length);
    return offset;
  }
  /// Frees an array for reuse; without memory for that, its place is never used again.
  void release(std::size_t offset, std::size_t length) noexcept {
    try {
      if (length >= free_.size()) free_.resize(length + 1);
      free_[length].push_back(offset);
    } catch (const std::bad_alloc&) {  // NOLINT(bugprone-empty-catch)
    }
  }

  T* at(std::size_t offset) { return data_.data() + offset; }
  const T* at(std::size_t offset) const { return data_.data() + offset; }
  std::size_t bytes() const { return data_.capacity() * sizeof(T); }

 private:
  std::vector<T> data_;
  std::vector<std::vector<std::size_t>> free_;
};

}  // namespace hybrid
