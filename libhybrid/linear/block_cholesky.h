// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/core/worker_pool.h"
#include "libhybrid/linear/block_matrix.h"

namespace HYBRID_API hybrid {

/// Cholesky factorisation L L' of a BlockMatrix (lower triangle) by the multifrontal method on
/// supernodes of whole blocks: analysed once, then factorised without allocation. Independent
/// subtrees and the columns of large fronts are shared among threads; every number is summed in one
/// fixed order, so that the factor is the same for any number of them.
class BlockCholesky {
 public:
  /// Columns of L with a common sparsity, stored as one dense panel: the rows `rows` (its own
  /// columns first, ascending), column-major with `stride` between columns.
  struct Supernode {
    int first = 0;    ///< first scalar column
    int columns = 0;  ///< number of scalar columns
    int parent = -1;  ///< supernode that receives its update
    int row_begin = 0;
    int height = 0;
    int stride = 0;
    std::size_t panel = 0;   // offset of the panel
    std::size_t update = 0;  // offset of the update matrix in the workspace
    int child_begin = 0;     // into children_
    int child_end = 0;
    int run_begin = 0;  // into runs_: the rows below in the parent's front
    int run_end = 0;
    int below() const { return height - columns; }
  };

  BlockCholesky() = default;
  BlockCholesky(const BlockMatrix& matrix, const BlockOrdering& ordering);

  /// Factorises matrix + diag(extra), where `extra` has one entry per scalar. Returns -1, or the
  /// first scalar column whose pivot is not positive; the factor is invalid then.
  int factorize(const BlockMatrix& matrix, const double* extra, WorkerPool& pool);

  /// x = (L L')^-1 x in place.
  void solve(double* x) const;
  /// x = L^-1 x in place.
  void solve_lower(double* x) const;
  /// x = L'^-1 x in place.
  void solve_upper(double* x) const;

  int size() const { return size_; }
  int supernode_count() const { return static_cast<int>(supernodes_.size()); }
  const Supernode& supernode(int s) const { return supernodes_[s]; }
  /// Supernode of a scalar column.
  int supernode_of(int scalar) const { return supernode_of_[scalar]; }
  /// Scalar rows of a supernode, ascending, its own columns first.
  const int* rows(const Supernode& s) const { return rows_.data() + s.row_begin; }
  const double* panel(const Supernode& s) const { return panels_.data() + s.panel; }
  /// Diagonal entry of L.
  double diagonal(int scalar) const { return 1.0 / inverse_diagonal_[scalar]; }

  /// Consecutive rows of an update matrix that stay consecutive in the parent's front: row `from` +
  /// i below the supernode is row `to` + i of the parent's panel.
  struct Run {
    int from = 0;
    int to = 0;
    int length = 0;
  };
  const Run* runs() const { return runs_.data(); }
  const int* children() const { return children_.data(); }
  /// Independent subtrees of supernodes, each in postorder; `top` holds the rest in postorder.
  const std::vector<std::vector<int>>& tasks() const { return tasks_; }
  const std::vector<int>& top() const { return top_; }
  std::size_t workspace_size() const { return workspace_.size(); }
  std::size_t panels_size() const { return panels_.size(); }

 private:
  void build_supernodes(const BlockMatrix& matrix, const BlockOrdering& ordering);
  void link_children();
  void place_blocks(const BlockMatrix& matrix);
  void split_into_tasks();
  std::size_t plan_updates(const std::vector<int>& list, std::size_t base);
  void load_panel(int s, const BlockMatrix& matrix, const double* extra);
  void add_to_panel(const Supernode& child, const Supernode& parent);
  void add_to_update(const Supernode& child, const Supernode& parent);
  int process(int s, const BlockMatrix& matrix, const double* extra, WorkerPool* pool);

  int size_ = 0;
  std::vector<Supernode> supernodes_;
  std::vector<int> supernode_of_;
  std::vector<int> rows_;
  std::vector<int> children_;
  std::vector<Run> runs_;
  std::vector<int> block_columns_;         // first block column of each supernode, and the end
  std::vector<std::size_t> block_places_;  // offset in the panels, by stored block
  std::vector<std::vector<int>> tasks_;    // independent subtrees in postorder
  std::vector<int> top_;                   // the rest, in postorder
  std::vector<double> panels_;
  std::vector<double> workspace_;
  std::vector<double> inverse_diagonal_;  // of L
};

}  // namespace hybrid
