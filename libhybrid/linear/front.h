// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/export.h"

namespace HYBRID_API hybrid {

struct Kernels;

/// Scratch for the frontal matrix of one clique: symmetric, lower triangle, column-major, with rows
/// and columns padded by zeros so that the kernels need no remainder loops.
class Front {
 public:
  Front() = default;
  explicit Front(const Kernels& kernels) : kernels_(&kernels) {}

  /// Makes it an all-zero matrix of order n.
  void reset(int n);

  int order() const { return n_; }
  int stride() const { return stride_; }
  double* column(int j) { return data_.data() + static_cast<std::size_t>(j) * stride_; }
  const double* column(int j) const { return data_.data() + static_cast<std::size_t>(j) * stride_; }
  double& operator()(int i, int j) { return column(j)[i]; }

  /// Partial Cholesky: the first f columns become those of L, the rest the Schur complement.
  /// Returns -1, or the first column whose pivot is not above `tolerance` times its diagonal entry
  /// before elimination.
  int factorize(int f, double tolerance);

  /// The same, but a pivot of column j below least[j] > 0 is lifted to it, and j is appended to
  /// `lifted`. Returns -1, or the first column whose pivot is not a finite number.
  int factorize(int f, const double* least, std::vector<int>& lifted);

 private:
  const Kernels* kernels_ = nullptr;  // null: those of this processor
  int n_ = 0;
  int stride_ = 0;
  std::vector<double> data_;
  std::vector<double> least_;
};

}  // namespace hybrid
