// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/robust/innovation.h"

#include <algorithm>

namespace hybrid {

const InnovationPredictor::Path& InnovationPredictor::path(int block) {
  if (paths_.empty()) paths_.resize(problem_.block_count());
  Path& path = paths_[block];
  if (path.y.size() > 0) return path;
  const NormalEquations& system = problem_.system();
  const BlockCholesky& factor = system.cholesky();
  const int start = system.start(block);
  const int dim = system.dim(block);
  int rows = 0;
  for (int s = factor.supernode_of(start); s >= 0; s = factor.supernode(s).parent) {
    path.supernodes.push_back(s);
    rows += factor.supernode(s).columns;
  }
  path.y.resize(rows, dim);
  for (int k = 0; k < dim; ++k) {
    scratch_[start + k] = 1.0;
    factor.solve_lower_along(path.supernodes.front(), scratch_.data());
    int row = 0;
    for (int s : path.supernodes) {
      const auto& node = factor.supernode(s);
      std::copy_n(&scratch_[node.first], node.columns, &path.y(row, k));
      std::fill_n(&scratch_[node.first], node.columns, 0.0);
      row += node.columns;
    }
  }
  return path;
}

InnovationPredictor::Linearized InnovationPredictor::linearize(
    const ContinuousFactor& factor) const {
  Linearized result;
  const std::size_t count = factor.keys().size();
  result.b.resize(factor.rows());
  result.J.resize(factor.rows(), factor.cols());
  std::vector<const double*> x(count);
  for (std::size_t i = 0; i < count; ++i) {
    result.blocks.push_back(problem_.block(factor.keys()[i]));
    x[i] = state_.data() + problem_.offset(result.blocks[i]);
  }
  factor.linearize(x.data(), result.b.data(), result.J.data());
  return result;
}

Eigen::VectorXd InnovationPredictor::residual(const ContinuousFactor& factor) const {
  return linearize(factor).b;
}

/// The covariance of two variables: the rows that their paths share.
Eigen::MatrixXd InnovationPredictor::covariance(int a, int b) {
  path(a);
  path(b);
  const Path& of_a = paths_[a];
  const Path& of_b = paths_[b];
  const BlockCholesky& cholesky = problem_.system().cholesky();
  int shared = 0;
  for (auto p = of_a.supernodes.rbegin(), q = of_b.supernodes.rbegin();
       p != of_a.supernodes.rend() && q != of_b.supernodes.rend() && *p == *q; ++p, ++q) {
    shared += cholesky.supernode(*p).columns;
  }
  return of_a.y.bottomRows(shared).transpose() * of_b.y.bottomRows(shared);
}

namespace {

/// Sum of J_i P_ij K_j' over the variables of two factors.
template <class Covariance>
Eigen::MatrixXd propagate(const Eigen::MatrixXd& J, const std::vector<int>& of_J,
                          const Eigen::MatrixXd& K, const std::vector<int>& of_K,
                          const NormalEquations& system, const Covariance& covariance) {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(J.rows(), K.rows());
  int row = 0;
  for (int i : of_J) {
    int col = 0;
    for (int j : of_K) {
      sum += J.middleCols(row, system.dim(i)) * covariance(i, j) *
             K.middleCols(col, system.dim(j)).transpose();
      col += system.dim(j);
    }
    row += system.dim(i);
  }
  return sum;
}

}  // namespace

Innovation InnovationPredictor::predict(const ContinuousFactor& factor) {
  const Linearized at = linearize(factor);
  return {at.b, propagate(at.J, at.blocks, at.J, at.blocks, problem_.system(),
                          [&](int i, int j) { return covariance(i, j); })};
}

Innovation InnovationPredictor::predict_joined(const ContinuousFactor& factor,
                                               const SelectedInverse& inverse) const {
  const Linearized at = linearize(factor);
  const NormalEquations& system = problem_.system();
  return {at.b, propagate(at.J, at.blocks, at.J, at.blocks, system, [&](int i, int j) {
            return inverse.block(system.start(i), system.dim(i), system.start(j), system.dim(j));
          })};
}

Eigen::MatrixXd InnovationPredictor::cross(const ContinuousFactor& a, const ContinuousFactor& b) {
  const Linearized of_a = linearize(a);
  const Linearized of_b = linearize(b);
  return propagate(of_a.J, of_a.blocks, of_b.J, of_b.blocks, problem_.system(),
                   [&](int i, int j) { return covariance(i, j); });
}

}  // namespace hybrid
