// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <utility>
#include <vector>

#include "libhybrid/core/assignment.h"
#include "libhybrid/core/key.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/linear/block_pattern.h"

namespace HYBRID_API hybrid {

/// The non-zero blocks of a matrix, as (row, column).
using Blocks = std::vector<std::pair<int, int>>;

/// The blocks of the Jacobian of a graph under an assignment: a row for each continuous factor and
/// chosen component, a column for each of their variables. Weak components are left out, since
/// solvers leave their off-diagonal blocks out of the system.
struct JacobianPattern {
  std::vector<Key> variables;             ///< columns, sorted
  std::vector<int> dims;                  ///< tangent dimension of each variable
  std::vector<std::vector<int>> factors;  ///< rows: the variables of each factor

  bool contains(Key key) const;
  /// Index of a variable; throws Error for one that no factor touches.
  int index(Key key) const;
};

JacobianPattern jacobian_pattern(const HybridGraph& graph, const Assignment& assignment);

/// Non-zero blocks of J, sorted.
Blocks jacobian_blocks(const JacobianPattern& jacobian);

/// The pattern of J'J.
BlockPattern information_pattern(const JacobianPattern& jacobian);

/// Blocks of a lower triangle, diagonal included, split by origin; sorted.
struct FilledPattern {
  Blocks original;  ///< blocks of the matrix itself
  Blocks fill;      ///< blocks that the elimination adds
};

/// The Cholesky factor of a matrix whose rows are eliminated in `order` (position -> block); rows
/// and columns are positions. Throws Error unless `order` names every block once.
FilledPattern cholesky_pattern(const BlockPattern& pattern, const std::vector<int>& order);

/// The sets of remaining blocks that marginalising the marked ones couples fully, one for each
/// connected set of marked blocks; sorted.
std::vector<std::vector<int>> marginal_cliques(const BlockPattern& pattern,
                                               const std::vector<char>& removed);

/// The information matrix that remains of `pattern` when the marked blocks are marginalised (Schur
/// complement): the neighbours of each connected set of them become fully coupled. Rows and columns
/// are the remaining blocks, renumbered without gaps.
FilledPattern marginalized_pattern(const BlockPattern& pattern, const std::vector<char>& removed);

}  // namespace hybrid
