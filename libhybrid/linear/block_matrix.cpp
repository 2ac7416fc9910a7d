// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/block_matrix.h"

#include <algorithm>

namespace hybrid {

BlockMatrix::BlockMatrix(const BlockPattern& pattern, const std::vector<int>& order,
                         Triangle triangle)
    : triangle_(triangle) {
  const int n = pattern.size();
  std::vector<int> position(n);
  starts_.assign(n + 1, 0);
  for (int p = 0; p < n; ++p) {
    position[order[p]] = p;
    starts_[p + 1] = starts_[p] + pattern.dims[order[p]];
  }

  block_starts_.assign(n + 1, 0);
  const auto place = [&](const std::pair<int, int>& edge) {
    const auto [low, high] = std::minmax(position[edge.first], position[edge.second]);
    return triangle == Triangle::kLower ? std::pair(high, low) : std::pair(low, high);
  };
  for (const auto& edge : pattern.edges) ++block_starts_[place(edge).second + 1];
  for (int p = 0; p < n; ++p) block_starts_[p + 1] += block_starts_[p] + 1;
  blocks_.resize(block_starts_[n]);
  std::vector<int> next(block_starts_.begin(), block_starts_.end() - 1);
  for (int p = 0; p < n; ++p) blocks_[next[p]++] = {p, p, 0};
  for (const auto& edge : pattern.edges) {
    const auto [row, col] = place(edge);
    blocks_[next[col]++] = {row, col, 0};
  }

  column_starts_.assign(1, 0);
  column_starts_.reserve(scalars() + 1);
  diagonal_.resize(scalars());
  for (int col = 0; col < n; ++col) {
    const auto begin = blocks_.begin() + block_starts_[col];
    const auto end = blocks_.begin() + block_starts_[col + 1];
    std::sort(begin, end, [](const Block& a, const Block& b) { return a.row < b.row; });
    const std::size_t first = rows_.size();
    for (auto block = begin; block != end; ++block) {
      block->offset = rows_.size();
      for (int r = starts_[block->row]; r < starts_[block->row + 1]; ++r) rows_.push_back(r);
    }
    const std::size_t height = rows_.size() - first;
    for (int c = 1; c < dim(col); ++c) {
      const std::size_t size = rows_.size();
      rows_.resize(size + height);
      std::copy_n(rows_.begin() + first, height, rows_.begin() + size);
    }
    for (int c = 0; c < dim(col); ++c) {
      column_starts_.push_back(static_cast<int>(first + (c + 1) * height));
      diagonal_[starts_[col] + c] = blocks_[diagonal(col)].offset + c * height + c;
    }
  }
  values_.assign(rows_.size(), 0.0);
}

int BlockMatrix::diagonal(int col) const {
  return triangle_ == Triangle::kLower ? block_starts_[col] : block_starts_[col + 1] - 1;
}

int BlockMatrix::find(int a, int b) const {
  const bool lower = triangle_ == Triangle::kLower;
  const int row = lower ? std::max(a, b) : std::min(a, b);
  const int col = lower ? std::min(a, b) : std::max(a, b);
  const auto begin = blocks_.begin() + block_starts_[col];
  const auto end = blocks_.begin() + block_starts_[col + 1];
  const auto it =
      std::lower_bound(begin, end, row, [](const Block& block, int r) { return block.row < r; });
  return it == end || it->row != row ? -1 : static_cast<int>(it - blocks_.begin());
}

void BlockMatrix::multiply(const double* x, double* y) const {
  std::fill(y, y + scalars(), 0.0);
  for (const Block& block : blocks_) {
    const int height = stride(block.col);
    for (int c = 0; c < dim(block.col); ++c) {
      const double* entries = values_.data() + block.offset + std::size_t(c) * height;
      const int j = starts_[block.col] + c;
      double sum = 0.0;
      for (int r = 0; r < dim(block.row); ++r) {
        const int i = starts_[block.row] + r;
        sum += entries[r] * x[i];
        if (block.row != block.col) y[i] += entries[r] * x[j];
      }
      y[j] += sum;
    }
  }
}

}  // namespace hybrid
