// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/pivoted_cholesky.h"

#include <cmath>
#include <utility>

namespace hybrid {

PivotedCholesky::PivotedCholesky(Eigen::MatrixXd matrix, double tolerance) {
  const Eigen::Index n = matrix.rows();
  order = Eigen::VectorXi::LinSpaced(n, 0, static_cast<int>(n) - 1);
  lower.setZero(n, n);
  Eigen::VectorXd left = matrix.diagonal();  // pivots, reduced by the columns so far
  Eigen::Index k = 0;
  for (; k < n; ++k) {
    Eigen::Index next = 0;
    const double pivot = left.tail(n - k).maxCoeff(&next);
    if (!(pivot > tolerance)) break;
    next += k;
    matrix.row(k).swap(matrix.row(next));
    matrix.col(k).swap(matrix.col(next));
    lower.row(k).swap(lower.row(next));
    std::swap(left[k], left[next]);
    std::swap(order[k], order[next]);
    const Eigen::Index below = n - k - 1;
    lower(k, k) = std::sqrt(pivot);
    auto column = lower.col(k).tail(below);
    column = matrix.col(k).tail(below);
    column.noalias() -= lower.bottomLeftCorner(below, k) * lower.row(k).head(k).transpose();
    column /= lower(k, k);
    left.tail(below) -= column.cwiseAbs2();
  }
  lower.conservativeResize(n, k);
}

}  // namespace hybrid
