// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <utility>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// Sparsity of a symmetric matrix made of dense blocks, one block row per variable.
struct BlockPattern {
  std::vector<int> dims;                   ///< tangent dimension of each block, positive
  std::vector<std::pair<int, int>> edges;  ///< off-diagonal blocks (i, j), i < j, sorted, unique
  /// A block that is known by itself (one with a prior), -1: none. It is eliminated last: blocks
  /// that a long chain connects to it then have pivots of the size of their own factors, and not
  /// the little that the chain leaves of the prior, which rounding may lose.
  int anchor = -1;

  int size() const { return static_cast<int>(dims.size()); }
  /// Scalar dimension of the matrix.
  int scalars() const;
};

/// An elimination order of the blocks, postordered, and what a Cholesky factorisation in that order
/// costs.
struct BlockOrdering {
  std::vector<int> order;  ///< position -> block
  double flops = 0.0;      ///< multiplications and additions of the factorisation
  double nonzeros = 0.0;   ///< scalar entries of the factor
  /// Supernodes: runs of positions with nearly the same structure, the first position of each and
  /// the end; and the positions of the blocks of each, its own first, ascending, for supernode s
  /// from row_starts[s] to row_starts[s + 1].
  std::vector<int> supernodes, row_starts, rows;
};

/// Whether the elimination tree may be as tall as a chain is long. Covariances cost its height; but
/// along a chain that ends at the anchor each pivot is then that of one link.
enum class Trees { kLow, kAnyHeight };

/// Fill-reducing order of whole blocks: approximate minimum degree and, where the factorisation is
/// expensive enough to repay it, nested dissection; the cheaper of the two.
BlockOrdering order_blocks(const BlockPattern& pattern, Trees trees = Trees::kLow);

}  // namespace hybrid
