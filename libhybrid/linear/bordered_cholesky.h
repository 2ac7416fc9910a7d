// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

/// A system S w = c that grows row by row, by its Cholesky factor. What is cut off again leaves no
/// trace.
class BorderedCholesky {
 public:
  int size() const { return static_cast<int>(reduced_.size()); }
  /// Appends row i of S, up to its diagonal, and c_i. Returns false, and appends nothing, where the
  /// pivot that is left of the diagonal is below `least`.
  bool append(const double* row, double c, double least);
  void truncate(int size);
  /// w.
  void solve(double* w) const;
  /// L^-1 x in place.
  void substitute(double* x) const;
  /// log det S.
  double log_determinant() const;
  std::size_t bytes() const { return (factor_.capacity() + reduced_.capacity()) * sizeof(double); }

 private:
  const double* row(int i) const {
    return factor_.data() + static_cast<std::size_t>(i) * (i + 1) / 2;
  }

  std::vector<double> factor_;   // rows of L, each up to its diagonal
  std::vector<double> reduced_;  // L^-1 c
};

}  // namespace hybrid
