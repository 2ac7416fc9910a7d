// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/innovation.h"

#include <Eigen/Cholesky>
#include <algorithm>

namespace hybrid {
namespace {

constexpr double kRounding = 1e-12;

}  // namespace

GivenOthers given_others(const Innovation& innovation, bool is_part) {
  const auto d = innovation.b.size();
  const Eigen::MatrixXd identity = Eigen::MatrixXd::Identity(d, d);
  if (!is_part) {
    const Eigen::MatrixXd S = identity + innovation.APAt;
    return {innovation.b, S, S.inverse().trace() / double(d)};
  }
  const Eigen::MatrixXd reduced = identity - innovation.APAt;
  Eigen::MatrixXd S = (reduced + kRounding * identity).ldlt().solve(identity);
  S = 0.5 * (S + S.transpose().eval());
  return {S * innovation.b, S, std::clamp(reduced.trace() / double(d), 0.0, 1.0)};
}

Innovation without(const Innovation& factor, const Innovation& part, const Eigen::MatrixXd& cross) {
  const GivenOthers alone = given_others(part, true);  // R^-1 b and R^-1
  return {factor.b + cross * alone.b, factor.APAt + cross * alone.S * cross.transpose()};
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

Eigen::MatrixXd InnovationPredictor::covariance(int a, int b) {
  const NormalEquations& system = problem_.system();
  return inverse_.block(system.start(a), system.dim(a), system.start(b), system.dim(b));
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
  // A P A' = W'W, where W = L^-1 A' is a sum over the variables, whose paths share their last rows.
  std::vector<Eigen::MatrixXd> parts;
  const NormalEquations& system = problem_.system();
  int column = 0;
  for (int block : at.blocks) {
    const int dim = system.dim(block);
    parts.emplace_back(inverse_.columns(system.start(block), dim)
                           .lazyProduct(at.J.middleCols(column, dim).transpose()));
    column += dim;
  }
  Innovation result{at.b, Eigen::MatrixXd::Zero(factor.rows(), factor.rows())};
  if (parts.size() == 2) {
    const int shared = inverse_.shared_rows(system.start(at.blocks[0]), system.start(at.blocks[1]));
    parts[0].bottomRows(shared) += parts[1].bottomRows(shared);
    const auto alone = parts[1].topRows(parts[1].rows() - shared);
    result.APAt += parts[0].transpose().lazyProduct(parts[0]);
    result.APAt += alone.transpose().lazyProduct(alone);
  } else {
    result.APAt = propagate(at.J, at.blocks, at.J, at.blocks, system,
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
