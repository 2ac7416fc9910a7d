// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/linear/block_pattern.h"

namespace HYBRID_API hybrid {

/// One triangle of a symmetric sparse matrix of dense blocks, its rows and columns already in
/// elimination order, as compressed scalar columns that CHOLMOD reads in place. Diagonal blocks are
/// stored whole, so that all columns of a block column have the same rows and every block is a
/// dense matrix with a fixed distance between its columns.
class BlockMatrix {
 public:
  enum class Triangle { kLower, kUpper };

  /// A stored block, by the positions of its row and column in the elimination order.
  struct Block {
    int row = 0;
    int col = 0;
    std::size_t offset = 0;  ///< of its first entry in `values()`
  };

  BlockMatrix() = default;
  BlockMatrix(const BlockPattern& pattern, const std::vector<int>& order, Triangle triangle);

  int size() const { return static_cast<int>(starts_.size()) - 1; }
  int scalars() const { return starts_.empty() ? 0 : starts_.back(); }
  Triangle triangle() const { return triangle_; }

  /// First scalar row of the block at a position, and its dimension.
  int start(int position) const { return starts_[position]; }
  int dim(int position) const { return starts_[position + 1] - starts_[position]; }

  /// The blocks of a column are block_begin(col) .. block_begin(col + 1) - 1, sorted by row.
  int block_begin(int col) const { return block_starts_[col]; }
  const Block& block(int index) const { return blocks_[index]; }
  int block_count() const { return static_cast<int>(blocks_.size()); }
  /// Index of the stored block that joins two positions, in either order; -1 if there is none.
  int find(int a, int b) const;
  int diagonal(int col) const;
  /// Distance between columns of all blocks of a block column.
  int stride(int col) const {
    return column_starts_[starts_[col] + 1] - column_starts_[starts_[col]];
  }

  const std::vector<int>& column_starts() const { return column_starts_; }
  const std::vector<int>& rows() const { return rows_; }
  const std::vector<double>& values() const { return values_; }
  std::vector<double>& values() { return values_; }
  /// Index in `values()` of the diagonal entry of a scalar column.
  std::size_t diagonal_offset(int scalar) const { return diagonal_[scalar]; }

  /// y = M x for the whole symmetric matrix.
  void multiply(const double* x, double* y) const;

 private:
  Triangle triangle_ = Triangle::kLower;
  std::vector<int> starts_;         // scalar start by position, one more at the end
  std::vector<int> block_starts_;   // first block by column, one more at the end
  std::vector<Block> blocks_;       // by column, then row
  std::vector<int> column_starts_;  // compressed scalar columns
  std::vector<int> rows_;
  std::vector<double> values_;
  std::vector<std::size_t> diagonal_;
};

}  // namespace hybrid
