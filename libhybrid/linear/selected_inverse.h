// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/linear/block_cholesky.h"

namespace HYBRID_API hybrid {

/// The entries of (L L')^-1 where L is not structurally zero, by Takahashi's recursion over the
/// supernodes from the root down: the covariances of all variables and of all pairs that some
/// factor joins, at about twice the cost of the factorisation. The factor must outlive it.
class SelectedInverse {
 public:
  SelectedInverse(const BlockCholesky& factor, WorkerPool& pool);

  /// The symmetric block of scalar rows and columns start .. start + dim - 1, which must be of one
  /// variable.
  Eigen::MatrixXd diagonal_block(int start, int dim) const;
  /// The block of the scalar rows from `row` on and the columns from `col` on, of two variables;
  /// throws Error if the factor is structurally zero there.
  Eigen::MatrixXd block(int row, int rows, int col, int cols) const;

 private:
  using Supernode = BlockCholesky::Supernode;
  /// Buffers of one thread.
  struct Scratch {
    std::vector<double> gain, coupling, inverse, own;
  };

  void invert(const Supernode& node, Scratch& scratch);
  void invert_columns(const Supernode& node, Scratch& scratch);
  void hand_down(const Supernode& child, const Supernode& parent);

  const BlockCholesky* factor_;
  std::vector<double> panels_;     // laid out as those of the factor
  std::vector<double> workspace_;  // inverses of the rows below each supernode, whole
};

}  // namespace hybrid
