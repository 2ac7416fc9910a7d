// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/extended_cholesky.h"

#include <Eigen/QR>
#include <cmath>
#include <limits>
#include <map>

namespace hybrid {

/// The pivot A of a column, in units of its scale, is stored as the root of its inverse: A^-1 =
/// root root'.
double ExtendedCholesky::log_determinant() const {
  if (nullity_ > 0) return -std::numeric_limits<double>::infinity();
  Real sum = 0.0L;
  for (const Front& front : fronts_) {
    for (std::size_t k = 0; k < front.columns.size(); ++k) {
      const Matrix& root = front.columns[k].root;
      sum += root.colPivHouseholderQr().logAbsDeterminant();
      sum += Real(root.rows()) * std::log(scale_[front.blocks[k]]);
    }
  }
  return static_cast<double>(-2.0L * sum);
}

/// Sigma = E' (L L')^-1 E = Y'Y with Y = L^-1 E, over the paths of the blocks to their roots.
Eigen::MatrixXd ExtendedCholesky::covariance(const std::vector<int>& blocks) const {
  std::map<int, int> rows;  // front -> where its own scalars stand in Y
  int columns = 0;
  for (int b : blocks) {
    for (int f = front_of_[b]; f >= 0; f = fronts_[f].parent) rows.emplace(f, 0);
    columns += dims_[b];
  }
  int size = 0;
  for (auto& [f, row] : rows) {
    row = size;
    size += fronts_[f].starts[fronts_[f].columns.size()];
  }
  const auto row_of = [&](int b) {
    const Front& own = fronts_[front_of_[b]];
    return rows.at(front_of_[b]) + starts_[b] - starts_[own.blocks[0]];
  };
  Matrix y = Matrix::Zero(size, columns);
  int column = 0;
  for (int b : blocks) {
    y.block(row_of(b), column, dims_[b], dims_[b]).diagonal().setConstant(scale_[b]);
    column += dims_[b];
  }
  for (const auto& [f, row] : rows) {
    const Front& front = fronts_[f];
    for (std::size_t k = 0; k < front.columns.size(); ++k) {
      const Column& eliminated = front.columns[k];
      auto own = y.middleRows(row + front.starts[k], dims_[front.blocks[k]]);
      const Matrix solved = eliminated.root.transpose() * own;
      own.setZero();
      own.topRows(solved.rows()) = solved;
      int below = 0;
      for (std::size_t i = k + 1; i < front.blocks.size(); ++i) {
        const int dim = dims_[front.blocks[i]];
        y.middleRows(row_of(front.blocks[i]), dim).noalias() -=
            eliminated.below.middleRows(below, dim) * solved;
        below += dim;
      }
    }
  }
  return (y.transpose() * y).cast<double>();
}

}  // namespace hybrid
