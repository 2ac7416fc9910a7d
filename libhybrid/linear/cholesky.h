// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <memory>
#include <vector>

#include "libhybrid/linear/block_matrix.h"

namespace HYBRID_API hybrid {

/// Cholesky factorisation M = L L' of a BlockMatrix by CHOLMOD, in the order of the matrix.
/// Analysed once, factorised as often as the values change.
class Cholesky {
 public:
  Cholesky();
  /// Supernodal or simplicial, as CHOLMOD predicts to be faster.
  explicit Cholesky(const BlockMatrix& matrix);
  ~Cholesky();
  Cholesky(Cholesky&&) noexcept;
  Cholesky& operator=(Cholesky&&) noexcept;

  /// Factorises the present values of the matrix, which must have the sparsity of the analysis.
  /// Returns -1, or the first scalar column whose pivot is not positive (or not finite).
  int factorize(const BlockMatrix& matrix);

  /// x = M^-1 x, in place, for `columns` right-hand sides of the matrix's scalar dimension.
  void solve(double* x, int columns = 1);

  /// Pivots L_jj^2: the information on scalar j with the earlier ones marginalised and the later
  /// ones given. Positive after a factorisation that succeeded.
  std::vector<double> pivots() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace hybrid
