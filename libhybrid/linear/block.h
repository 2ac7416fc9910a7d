// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// An array of doubles that is not initialised. Copies are deep.
class Block {
 public:
  Block() = default;
  explicit Block(std::size_t size) : data_(size == 0 ? nullptr : new double[size]), size_(size) {}
  Block(const Block& other) : Block(other.size_) { std::copy_n(other.data(), size_, data()); }
  Block(Block&& other) noexcept
      : data_(std::move(other.data_)), size_(std::exchange(other.size_, 0)) {}
  Block& operator=(Block other) noexcept {
    data_ = std::move(other.data_);
    size_ = other.size_;
    return *this;
  }
  ~Block() = default;

  double* data() { return data_.get(); }
  const double* data() const { return data_.get(); }
  std::size_t bytes() const { return size_ * sizeof(double); }

 private:
  std::unique_ptr<double[]> data_;
  std::size_t size_ = 0;
};

}  // namespace hybrid
