// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/detail/exchange.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>
#include <utility>

namespace hybrid {
namespace {

/// Rows have unit length over variables of unit variance; the part of a row orthogonal to the
/// directions found so far is rounding error if it is shorter than this.
constexpr double kNewDirection = 1e-9;
/// If the information on a direction falls below this share, only the removed factors determined
/// it. Covariances are accurate to some 1e-12.
constexpr double kLeastDirectionShare = 1e-10;

/// An orthonormal basis, as columns, of the directions that the rows of some factors measure.
Eigen::MatrixXd basis(const std::vector<LinearRows>& factors, int size) {
  int count = 0;
  for (const LinearRows& rows : factors) count += static_cast<int>(rows.J.rows());
  if (count == 0) return {size, 0};
  Eigen::MatrixXd all = Eigen::MatrixXd::Zero(size, count);
  int column = 0;
  for (const LinearRows& rows : factors) {
    for (int i = 0; i < rows.J.rows(); ++i, ++column) {
      const double length = rows.J.row(i).norm();
      if (length > 0.0) all.col(column) = rows.J.row(i).transpose() / length;
    }
  }
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(all);
  qr.setThreshold(kNewDirection);
  return qr.householderQ() * Eigen::MatrixXd::Identity(size, qr.rank());
}

}  // namespace

Exchange::Exchange(const JointGaussian& gaussian, const std::vector<Site>& sites) {
  const int size = gaussian.size();
  // Variables are scaled to unit variance, so that units do not matter.
  const Eigen::VectorXd sigmas = gaussian.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
  std::vector<Eigen::MatrixXd> bases;
  int total = 0;
  for (const Site& site : sites) {
    std::vector<LinearRows> factors;
    for (const ContinuousFactor* factor : site.factors) {
      factors.push_back(linear_rows(factor, gaussian));
      factors.back().J *= sigmas.asDiagonal();
    }
    bases.push_back(basis(factors, size));
    Directions own;
    own.begin = total;
    own.size = static_cast<int>(bases.back().cols());
    own.present = site.present;
    for (const LinearRows& rows : factors) {
      const Eigen::MatrixXd S = rows.J * bases.back();
      own.factors.push_back({S.transpose() * S, S.transpose() * rows.r});
    }
    const Difference present = own.factors[site.present];
    for (Difference& difference : own.factors) {
      difference.M -= present.M;
      difference.q -= present.q;
    }
    total += own.size;
    sites_.push_back(std::move(own));
  }
  Eigen::MatrixXd B(size, total);
  for (std::size_t k = 0; k < bases.size(); ++k) {
    B.middleCols(sites_[k].begin, sites_[k].size) = bases[k];
  }
  B.array().colwise() *= sigmas.unaryExpr([](double s) { return s > 0.0 ? 1.0 / s : 0.0; }).array();
  G_ = B.transpose() * gaussian.covariance * B;
}

std::optional<double> Exchange::log_change(const std::vector<int>& chosen) const {
  std::vector<int> exchanged;
  int size = 0;
  for (std::size_t k = 0; k < sites_.size(); ++k) {
    if (chosen[k] == sites_[k].present) continue;
    exchanged.push_back(static_cast<int>(k));
    size += sites_[k].size;
  }
  if (size == 0) return 0.0;
  Eigen::MatrixXd A(size, size);  // I + G M
  Eigen::VectorXd q(size), Gq = Eigen::VectorXd::Zero(size);
  int column = 0;
  for (int k : exchanged) {
    const Directions& from = sites_[k];
    const Difference& difference = from.factors[chosen[k]];
    q.segment(column, from.size) = difference.q;
    int row = 0;
    for (int l : exchanged) {
      const Directions& to = sites_[l];
      const auto G = G_.block(to.begin, from.begin, to.size, from.size);
      A.block(row, column, to.size, from.size).noalias() = G * difference.M;
      Gq.segment(row, to.size).noalias() += G * difference.q;
      row += to.size;
    }
    column += from.size;
  }
  A.diagonal().array() += 1.0;
  const Eigen::PartialPivLU<Eigen::MatrixXd> lu(A);
  double log_det = 0.0;
  double sign = lu.permutationP().determinant();
  for (int i = 0; i < size; ++i) {
    const double pivot = lu.matrixLU()(i, i);
    if (!(std::abs(pivot) > kLeastDirectionShare)) return std::nullopt;
    log_det += std::log(std::abs(pivot));
    if (pivot < 0.0) sign = -sign;
  }
  if (sign < 0.0) return std::nullopt;
  return 0.5 * (q.dot(lu.solve(Gq)) - log_det);
}

}  // namespace hybrid
