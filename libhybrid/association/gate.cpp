// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/gate.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

namespace hybrid {
namespace {

/// Quantile of the standard normal distribution: the rational approximation of Abramowitz and
/// Stegun 26.2.23, within 4.5e-4.
double normal_quantile(double p) {
  const bool upper = p > 0.5;
  const double t = std::sqrt(-2.0 * std::log(upper ? 1.0 - p : p));
  const double z = t - (2.515517 + t * (0.802853 + t * 0.010328)) /
                           (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
  return upper ? z : -z;
}

}  // namespace

double chi_square_quantile(double p, int dof) {
  const double h = 2.0 / (9.0 * dof);
  const double root = 1.0 - h + normal_quantile(p) * std::sqrt(h);
  return dof * root * root * root;
}

GaussianScore gaussian_score(const Eigen::VectorXd& residual, const Eigen::MatrixXd& covariance) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  const Eigen::LLT<Eigen::MatrixXd> llt(covariance);
  if (llt.info() != Eigen::Success) return {kInfinity, kInfinity};
  const Eigen::VectorXd whitened = llt.matrixL().solve(residual);
  GaussianScore score;
  score.chi_square = whitened.squaredNorm();
  score.cost =
      0.5 * score.chi_square + 0.5 * static_cast<double>(residual.size()) * std::log(2 * M_PI);
  for (Eigen::Index i = 0; i < residual.size(); ++i) {
    score.cost += std::log(llt.matrixLLT()(i, i));
  }
  return score;
}

}  // namespace hybrid
