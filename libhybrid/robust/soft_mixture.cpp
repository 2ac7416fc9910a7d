// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/robust/soft_mixture.h"

#include <cmath>

#include "libhybrid/core/elapsed.h"

namespace hybrid {
namespace {

/// Probability of the outlier component, where it costs `excess` / 2 more than the inlier's.
double outlier_probability(double excess) {
  return 1.0 / (1.0 + std::exp(0.5 * excess));
}

/// -2 log(1 + exp(-x / 2)) for all x, without overflow.
double soft_part(double x) {
  return x > 0.0 ? -2.0 * std::log1p(std::exp(-0.5 * x)) : x - 2.0 * std::log1p(std::exp(0.5 * x));
}

}  // namespace

Kernel soft_mixture_kernel(double outlier_variance, double offset) {
  const double weight = 1.0 / outlier_variance;
  const double at_zero = soft_part(offset);
  return {[=](double s) { return s + soft_part(offset + (weight - 1.0) * s) - at_zero; },
          [=](double s) {
            const double p = outlier_probability(offset + (weight - 1.0) * s);
            return 1.0 - p + weight * p;
          }};
}

Kernel soft_mixture_kernel(const ContinuousFactor& closure, const MixtureOptions& mixture) {
  if (!(mixture.inlier_weight > 0.0) || !(mixture.outlier_weight > 0.0)) {
    throw Error("weights of inliers and outliers must be positive");
  }
  const double prior = 2.0 * std::log(mixture.inlier_weight / mixture.outlier_weight);
  if (mixture.null_hypothesis) {
    return soft_mixture_kernel(INFINITY,
                               2.0 * (*mixture.null_hypothesis - closure.log_normalizer()) + prior);
  }
  return soft_mixture_kernel(mixture.flat ? INFINITY : mixture.outlier_variance,
                             closure.rows() * std::log(mixture.outlier_variance) + prior);
}

RobustResult solve_soft_mixture(const RobustProblem& problem, const ComparisonOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<Kernel> kernels;
  for (const ContinuousFactorPtr& closure : problem.closures) {
    kernels.push_back(soft_mixture_kernel(*closure, options.mixture));
  }
  RobustResult result = solve_kernels(problem, kernels, options);
  result.method = "sum-mixture";
  const std::vector<double> chi_square = chi_squares(problem, result.values);
  std::vector<bool> accepted;
  for (std::size_t k = 0; k < kernels.size(); ++k) {
    accepted.push_back(kernels[k].weight(chi_square[k]) >= 0.5);
  }
  finish(problem, accepted, options.mixture, result);
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
