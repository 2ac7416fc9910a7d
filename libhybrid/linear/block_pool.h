// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A pool of uninitialised arrays of doubles for frequent use: freed ones are kept by size class
/// (four per doubling), so that memory is neither zeroed nor returned to the system in between.
class BlockPool {
 public:
  /// Copies are deep.
  class Block {
   public:
    Block() = default;
    Block(const Block& other) : Block(other.capacity_) {
      std::copy_n(other.data(), capacity_, data());
    }
    Block(Block&& other) noexcept
        : data_(std::move(other.data_)), capacity_(std::exchange(other.capacity_, 0)) {}
    Block& operator=(Block other) noexcept {
      data_ = std::move(other.data_);
      capacity_ = other.capacity_;
      return *this;
    }
    ~Block() = default;

    double* data() { return data_.get(); }
    const double* data() const { return data_.get(); }

   private:
    friend class BlockPool;
    explicit Block(std::size_t capacity)
        : data_(capacity == 0 ? nullptr : new double[capacity]), capacity_(capacity) {}

    std::unique_ptr<double[]> data_;
    std::size_t capacity_ = 0;
  };

  Block take(std::size_t size) {
    std::size_t capacity = 0;
    const std::size_t index = size_class(size, &capacity);
    if (index >= free_.size()) free_.resize(index + 1);
    if (free_[index].empty()) {
      Block block(capacity);
      bytes_ += capacity * sizeof(double);
      return block;
    }
    Block block = std::move(free_[index].back());
    free_[index].pop_back();
    return block;
  }

  void give(Block block) noexcept {
    if (block.data() == nullptr) return;
    std::size_t capacity = 0;
    try {
      free_[size_class(block.capacity_, &capacity)].push_back(std::move(block));
    } catch (const std::bad_alloc&) {  // its memory returns to the system
      bytes_ -= capacity * sizeof(double);
    }
  }

  /// Bytes ever taken from the system, in use or kept.
  std::size_t bytes() const { return bytes_; }

 private:
  static std::size_t size_class(std::size_t size, std::size_t* capacity) {
    std::size_t base = 16;
    std::size_t index = 0;
    while (2 * base < size) {
      base *= 2;
      index += 4;
    }
    std::size_t c = base;
    while (c < size) {
      c += base / 4;
      ++index;
    }
    *capacity = c;
    return index;
  }

  std::vector<std::vector<Block>> free_;
  std::size_t bytes_ = 0;
};

}  // namespace hybrid
