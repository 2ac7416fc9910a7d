// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/core/worker_pool.h"
#include "libhybrid/linear/block_cholesky.h"
#include "libhybrid/linear/block_matrix.h"

namespace HYBRID_API hybrid {

/// How a system is eliminated.
enum class Elimination {
  kAutomatic,  ///< by Schur complement if that is faster
  kPlain,      ///< sparse Cholesky of the whole system
  kSchur       ///< leaves first, then sparse Cholesky of their Schur complement
};

/// Blocks with no edge between them, found greedily by ascending degree, such as the landmarks of a
/// map: they can be eliminated one by one before all others.
std::vector<int> independent_blocks(const BlockPattern& pattern);

/// Whether eliminating these leaves first by Schur complement is faster than sparse Cholesky.
bool schur_pays(const BlockPattern& pattern, const std::vector<int>& leaves);

/// An order for the Schur complement: the leaves, then the other blocks in a fill-reducing order of
/// the reduced system.
struct SchurOrdering {
  std::vector<int> order;  ///< position -> block, leaves first
  int leaves = 0;
  BlockPattern reduced;            ///< over the positions after the leaves
  BlockOrdering reduced_ordering;  ///< the identity order of those, with its supernodes
};
SchurOrdering order_schur(const BlockPattern& pattern, const std::vector<int>& leaves);

/// Cholesky factorisation of a system [V W'; W C] with V block-diagonal: with V = L L' and Y = W
/// L'^-1, the reduced system S = C - Y Y' is factorised, and leaves are found by back-substitution.
/// The matrix is in the order of a SchurOrdering. Every number is summed in one fixed order,
/// whatever the number of threads.
class SchurCholesky {
 public:
  SchurCholesky() = default;
  SchurCholesky(const BlockMatrix& matrix, const SchurOrdering& ordering);

  /// As BlockCholesky::factorize.
  int factorize(const BlockMatrix& matrix, const double* extra, WorkerPool& pool);
  /// x = M^-1 x in place.
  void solve(double* x) const;
  /// Diagonal entry of the factor at a scalar column.
  double diagonal(int scalar) const;

  int leaf_count() const { return static_cast<int>(leaves_.size()); }

 private:
  /// Columns of one leaf; its blocks are edges_[first] .. edges_[last - 1], by ascending row.
  struct Leaf {
    int start = 0;  // scalar
    int dim = 0;
    int height = 0;         // rows below the diagonal block
    std::size_t place = 0;  // offset of V and W in the matrix
    std::size_t y = 0;      // offset of Y in y_, column-major with `height` rows
    int first = 0, last = 0;
  };
  struct Edge {
    int row = 0;     // position in the reduced system
    int offset = 0;  // of its rows in the leaf's Y
  };
  struct Incidence {
    int leaf = 0;
    int edge = 0;
  };

  void collect_leaves(const BlockMatrix& matrix, int leaves);
  int eliminate(const Leaf& leaf, const BlockMatrix& matrix, const double* extra);
  void reduce_column(int col, const BlockMatrix& matrix, std::vector<int>& place);

  std::vector<Leaf> leaves_;
  std::vector<Edge> edges_;
  std::vector<int> incidence_begin_;  // by position in the reduced system
  std::vector<Incidence> incidences_;
  int leaf_scalars_ = 0;
  BlockMatrix reduced_;
  BlockCholesky cholesky_;
  std::vector<double> y_, factors_;  // factors_: L of each leaf, dim x dim at dim * start
};

}  // namespace hybrid
