// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/detail/stated_noise.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <cmath>

namespace hybrid {
namespace {

bool is_sigma(double x) {
  return x >= kLeastSigma && x <= kLargestSigma;
}

}  // namespace

double stated_sigma(const TextRow& row, std::size_t i) {
  const double sigma = row.number(i);
  if (is_sigma(sigma)) return sigma;
  row.fail(i, fmt::format("a standard deviation of {}; expected one from {} to {}", sigma,
                          kLeastSigma, kLargestSigma));
}

void check_covariance(const TextRow& row, std::size_t i, const Eigen::MatrixXd& covariance) {
  constexpr double kRounding = 1e-6;  // relative rounding error of printed covariances
  const bool symmetric =
      covariance.allFinite() && covariance.isApprox(covariance.transpose(), kRounding);
  if (!symmetric || covariance.llt().info() != Eigen::Success) {
    row.fail(i, "a covariance or information that is not symmetric and positive definite");
  }
  for (Eigen::Index k = 0; k < covariance.rows(); ++k) {
    const double sigma = std::sqrt(covariance(k, k));
    if (is_sigma(sigma)) continue;
    row.fail(i, fmt::format("standard deviation {} of the covariance is {}; expected {} to {}",
                            k + 1, sigma, kLeastSigma, kLargestSigma));
  }
}

}  // namespace hybrid
