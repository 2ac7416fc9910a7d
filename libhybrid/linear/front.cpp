// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/front.h"

#include <algorithm>

#include "libhybrid/linear/kernels/kernels.h"

namespace hybrid {
namespace {

constexpr int kPaddingColumns = 4;

}  // namespace

void Front::reset(int n) {
  if (kernels_ == nullptr) kernels_ = &kernels();
  n_ = n;
  stride_ = round_up(n + kernels_->front_padding);
  const std::size_t size = static_cast<std::size_t>(stride_) * (n + kPaddingColumns);
  if (data_.size() < size) data_.resize(size + size / 2);
  for (int j = 0; j < n + kPaddingColumns; ++j)
    std::fill(column(j) + std::min(j, n), column(j) + stride_, 0.0);
}

int Front::factorize(int f, double tolerance) {
  least_.resize(f);
  for (int j = 0; j < f; ++j) least_[j] = tolerance * (*this)(j, j);
  Pivots pivots{least_.data(), nullptr, 0};
  return kernels_->eliminate(data_.data(), n_, stride_, f, pivots);
}

int Front::factorize(int f, const double* least, std::vector<int>& lifted) {
  const std::size_t before = lifted.size();
  lifted.resize(before + f);
  Pivots pivots{least, lifted.data() + before, 0};
  const int failed = kernels_->eliminate(data_.data(), n_, stride_, f, pivots);
  lifted.resize(before + pivots.lifted_count);
  return failed;
}

}  // namespace hybrid
