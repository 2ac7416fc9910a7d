// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <unordered_map>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/linear/block_cholesky.h"

namespace HYBRID_API hybrid {

/// Blocks of (L L')^-1 from columns of L^-1, which are zero outside the path of a variable to the
/// root of the elimination tree. Columns are kept by variable. The factor must outlive it and must
/// not change.
class PathInverse {
 public:
  explicit PathInverse(const BlockCholesky& factor) : factor_(&factor) {}

  /// L^-1 E for the columns E of a variable, restricted to the rows along its path from the
  /// supernode of the variable to the root.
  const Eigen::MatrixXd& columns(int start, int dim) { return path(start, dim).y; }
  /// Number of rows, the last ones, that the paths of two variables have in common; the columns of
  /// both must have been computed.
  int shared_rows(int start_a, int start_b) const;
  /// The block of the inverse for two variables, by first scalar and dimension.
  Eigen::MatrixXd block(int start_a, int dim_a, int start_b, int dim_b);

 private:
  using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  struct Path {
    Eigen::MatrixXd y;
    std::vector<int> supernodes;
  };

  const Path& path(int start, int dim);

  const BlockCholesky* factor_;
  std::unordered_map<int, Path> paths_;  // by first scalar
  RowMatrix scratch_;
};

}  // namespace hybrid
