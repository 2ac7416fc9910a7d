// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <utility>
#include <vector>

#include "libhybrid/linear/extended_cholesky.h"

namespace hybrid {

/// Computes the factorisation.
class ExtendedCholesky::Builder {
 public:
  Builder(ExtendedCholesky& result, const ResidualLayout& layout, const double* J)
      : out_(result), fronts_(result.fronts_), dims_(result.dims_), layout_(layout), J_(J) {}

  void run() {
    number_blocks();
    build_fronts();
    place_residuals();
    for (Front& front : fronts_) factorize(front);
    for (std::size_t b = 0; b < moves_.size(); ++b) collect_directions(static_cast<int>(b));
  }

 private:
  void number_blocks();
  void build_fronts();
  void place_residuals();
  void factorize(Front& front);
  void add_residual(int residual, int alone, Matrix& F) const;
  void add_update(const Front& child, Matrix& F) const;
  void eliminate_block(Front& front, int k, Matrix& F);
  Matrix root_by_eigenvalues(Front& front, int k, const Matrix& A);
  Matrix slow_motion(const Front& front, int k, const Matrix& directions, Matrix& squared);
  void solve_lower(const Front& front, int columns, Matrix& x) const;
  void solve_upper(const Front& front, int columns, bool homogeneous, Matrix& x) const;
  Matrix gradient(const Front& front, const Matrix& v, Matrix& squared) const;
  void add_null_vector(const Front& front, const Matrix& v);
  void collect_directions(int block);

  /// Calls visit(block, its part of the Jacobian, not scaled) for the blocks of a residual.
  template <class Visit>
  void visit_blocks(const std::pair<int, int>& residual, const Visit& visit) const {
    const auto& r = layout_.residuals[residual.first];
    const double* entry = J_ + r.jacobian;
    for (int i = 0; i < r.count; ++i) {
      const int b = layout_.blocks[r.first + i];
      if (residual.second < 0 || residual.second == i) {
        visit(b, Eigen::Map<const Eigen::MatrixXd>(entry, r.rows, dims_[b]).cast<Real>());
      }
      entry += r.rows * dims_[b];
    }
  }
  /// The rows of a block in a vector over a subtree, which concatenates the own blocks of its
  /// fronts.
  auto rows(Matrix& x, int block) const {
    return x.middleRows(out_.starts_[block] - base_, dims_[block]);
  }
  auto rows(const Matrix& x, int block) const {
    return x.middleRows(out_.starts_[block] - base_, dims_[block]);
  }
  bool is_in(const Front& front, int block) const {
    return out_.front_of_[block] <= &front - fronts_.data();
  }
  /// Calls visit(front, number of columns) for all fronts below `front`, then with k for `front`.
  template <class Visit>
  void visit_up(const Front& front, int k, const Visit& visit) const {
    const int last = static_cast<int>(&front - fronts_.data());
    for (int f = front.first; f < last; ++f) {
      visit(fronts_[f], static_cast<int>(fronts_[f].columns.size()));
    }
    visit(front, k);
  }

  ExtendedCholesky& out_;
  std::vector<Front>& fronts_;
  const std::vector<int>& dims_;
  const ResidualLayout& layout_;
  const double* J_;
  std::vector<int> place_;     // by block: its first scalar in the current front
  int base_ = 0;               // first scalar of the current subtree
  std::vector<Matrix> moves_;  // by block: sum of u u' for its unit motions u by null vectors
};

}  // namespace hybrid
