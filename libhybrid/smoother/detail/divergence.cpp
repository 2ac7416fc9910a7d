// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/detail/divergence.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

#include "libhybrid/factors/linear_at.h"

namespace hybrid {
namespace {

/// Shares of the information that differ from all of it by no more than rounding.
constexpr double kShareRounding = 1e-9;

}  // namespace

double divergence_without(
    const std::vector<const ContinuousFactor*>& factors, const Values& values,
    const std::function<Eigen::MatrixXd(const std::vector<Key>&)>& joint_covariance) {
  std::vector<Key> keys;
  std::unordered_map<Key, Eigen::Index> column;
  Eigen::Index rows = 0, cols = 0;
  for (const ContinuousFactor* factor : factors) {
    rows += factor->rows();
    for (std::size_t i = 0; i < factor->keys().size(); ++i) {
      if (!column.emplace(factor->keys()[i], cols).second) continue;
      keys.push_back(factor->keys()[i]);
      cols += factor->types()[i].dim;
    }
  }
  if (rows == 0) return 0.0;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(rows, cols);
  Eigen::VectorXd r(rows);
  Eigen::Index row = 0;
  for (const ContinuousFactor* factor : factors) {
    const auto [residual, own] = linear_at(*factor, values);
    Eigen::Index from = 0;
    for (std::size_t i = 0; i < factor->keys().size(); ++i) {
      const int dim = factor->types()[i].dim;
      J.block(row, column.at(factor->keys()[i]), own.rows(), dim) = own.middleCols(from, dim);
      from += dim;
    }
    r.segment(row, own.rows()) = residual;
    row += own.rows();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> C(J * joint_covariance(keys) *
                                                         J.transpose());
  const Eigen::VectorXd along = C.eigenvectors().transpose() * r;
  double divergence = 0.0;
  for (Eigen::Index i = 0; i < rows; ++i) {
    const double share = std::max(0.0, C.eigenvalues()[i]);  // of the information, theirs
    if (!(share < 1.0 - kShareRounding)) return std::numeric_limits<double>::infinity();
    divergence += 0.5 * (along[i] * along[i] * share / (1.0 - share) - share - std::log1p(-share));
  }
  return divergence;
}

}  // namespace hybrid
