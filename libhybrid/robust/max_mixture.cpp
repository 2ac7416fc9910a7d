// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/robust/max_mixture.h"

#include <algorithm>
#include <cmath>

#include "libhybrid/core/elapsed.h"

namespace hybrid {

Kernel max_mixture_kernel(double outlier_variance, double offset) {
  const double weight = 1.0 / outlier_variance;
  return {[=](double s) { return std::min(s, weight * s + offset); },
          [=](double s) { return s <= weight * s + offset ? 1.0 : weight; }};
}

Kernel max_mixture_kernel(const ContinuousFactor& closure, const MixtureOptions& mixture) {
  if (!(mixture.inlier_weight > 0.0) || !(mixture.outlier_weight > 0.0)) {
    throw Error("weights of inliers and outliers must be positive");
  }
  const double prior = 2.0 * std::log(mixture.inlier_weight / mixture.outlier_weight);
  if (mixture.null_hypothesis) {
    const double offset = 2.0 * (*mixture.null_hypothesis - closure.log_normalizer()) + prior;
    return max_mixture_kernel(INFINITY, offset);
  }
  return max_mixture_kernel(mixture.outlier_variance,
                            closure.rows() * std::log(mixture.outlier_variance) + prior);
}

RobustResult solve_max_mixture(const RobustProblem& problem, const ComparisonOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<Kernel> kernels;
  for (const ContinuousFactorPtr& closure : problem.closures) {
    kernels.push_back(max_mixture_kernel(*closure, options.mixture));
  }
  RobustResult result = solve_kernels(problem, kernels, options);
  result.method = "max-mixture";
  const std::vector<double> chi_square = chi_squares(problem, result.values);
  std::vector<bool> accepted;
  for (std::size_t k = 0; k < kernels.size(); ++k) {
    accepted.push_back(kernels[k].weight(chi_square[k]) == 1.0);
  }
  finish(problem, accepted, options.mixture, result);
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
