// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

namespace hybrid {

/// Uninitialised arrays of doubles that come and go often: freed ones are kept by size class (four
/// to the octave), so that memory is neither zeroed nor handed back to the system in between.
class BlockPool {
 public:
  struct Block {
    std::unique_ptr<double[]> data;
    std::size_t capacity = 0;
  };

  Block take(std::size_t size) {
    std::size_t capacity = 0;
    const std::size_t index = size_class(size, &capacity);
    if (index >= free_.size()) free_.resize(index + 1);
    if (free_[index].empty()) {
      bytes_ += capacity * sizeof(double);
      return {std::unique_ptr<double[]>(new double[capacity]), capacity};
    }
    Block block = std::move(free_[index].back());
    free_[index].pop_back();
    return block;
  }

  void give(Block block) {
    if (block.data == nullptr) return;
    std::size_t capacity = 0;
    free_[size_class(block.capacity, &capacity)].push_back(std::move(block));
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
