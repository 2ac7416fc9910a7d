// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/robust/innovation.h"

#include <algorithm>

#include "libhybrid/linear/substitute.h"

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
  // L x = E for all columns at once; x is zero but on the path.
  path.y.resize(rows, dim);
  scratch_.resize(system.scalars(), dim);
  for (int s : path.supernodes) {
    const auto& node = factor.supernode(s);
    scratch_.middleRows(node.first, node.columns).setZero();
  }
  scratch_.middleRows(start, dim).setIdentity();
  int row = 0;
  Eigen::MatrixXd front;
  for (int s : path.supernodes) {
    const auto& node = factor.supernode(s);
    front.setZero(node.height, dim);
    front.topRows(node.columns) = scratch_.middleRows(node.first, node.columns);
    for (int d = 0; d < dim; ++d) {
      substitute(factor.panel(node), node.stride, node.height, node.columns, front.col(d).data());
    }
    path.y.middleRows(row, node.columns) = front.topRows(node.columns);
    const int* below = factor.rows(node) + node.columns;
    for (int r = 0; r < node.below(); ++r) scratch_.row(below[r]) += front.row(node.columns + r);
    row += node.columns;
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

int InnovationPredictor::shared_rows(int a, int b) const {
  const std::vector<int>& of_a = paths_[a].supernodes;
  const std::vector<int>& of_b = paths_[b].supernodes;
  const BlockCholesky& cholesky = problem_.system().cholesky();
  int shared = 0;
  for (auto p = of_a.rbegin(), q = of_b.rbegin(); p != of_a.rend() && q != of_b.rend() && *p == *q;
       ++p, ++q) {
    shared += cholesky.supernode(*p).columns;
  }
  return shared;
}

/// The covariance of two variables, from the rows that their paths share.
Eigen::MatrixXd InnovationPredictor::covariance(int a, int b) {
  path(a);
  path(b);
  const int shared = shared_rows(a, b);
  return paths_[a].y.bottomRows(shared).transpose() * paths_[b].y.bottomRows(shared);
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
  // A P A' = W'W with W = L^-1 A', the sum over the variables; the ends of their paths coincide.
  std::vector<Eigen::MatrixXd> parts;
  int column = 0;
  for (int block : at.blocks) {
    const Path& own = path(block);
    parts.emplace_back(own.y * at.J.middleCols(column, own.y.cols()).transpose());
    column += static_cast<int>(own.y.cols());
  }
  Innovation result{at.b, Eigen::MatrixXd::Zero(factor.rows(), factor.rows())};
  if (parts.size() == 2) {
    const int shared = shared_rows(at.blocks[0], at.blocks[1]);
    parts[0].bottomRows(shared) += parts[1].bottomRows(shared);
    const auto alone = parts[1].topRows(parts[1].rows() - shared);
    result.APAt.noalias() += parts[0].transpose() * parts[0];
    result.APAt.noalias() += alone.transpose() * alone;
  } else {
    result.APAt = propagate(at.J, at.blocks, at.J, at.blocks, problem_.system(),
                            [&](int i, int j) { return covariance(i, j); });
  }
  return result;
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
