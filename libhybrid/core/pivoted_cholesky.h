// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Cholesky factorisation of a positive semidefinite matrix A that reveals its rank: P A P' = L L',
/// the largest remaining pivot first (Higham, Analysis of the Cholesky decomposition of a
/// semi-definite matrix, 1990). Eigen's LDLT is none: it chooses among pivots that are not reduced
/// yet, so that one of zero may come before others.
struct PivotedCholesky {
  Eigen::VectorXi order;  ///< row k of P A is row order[k] of A
  Eigen::MatrixXd lower;  ///< L, rows in this order, one column for each pivot above the tolerance

  /// Reads all of `matrix`, of n rows. Costs n^2 times the rank.
  PivotedCholesky(Eigen::MatrixXd matrix, double tolerance);

  int rank() const { return static_cast<int>(lower.cols()); }
  /// The rows of a matrix or vector that belong to the pivots, in their order.
  Eigen::MatrixXd pivots_of(const Eigen::MatrixXd& rows) const {
    return rows(order.head(rank()), Eigen::all);
  }
  /// L of the pivots alone.
  auto triangle() const { return lower.topRows(rank()).triangularView<Eigen::Lower>(); }
};

}  // namespace hybrid
