// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/baselines/soft_mixture.h"

#include <cmath>

namespace hybrid {
namespace {

/// Probability of the outlier component if it costs `excess` / 2 more than the inlier component.
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
  const OutlierLine line = outlier_line(closure, mixture);
  return soft_mixture_kernel(line.variance, line.offset);
}

RobustResult solve_soft_mixture(const RobustProblem& problem, const ComparisonOptions& options) {
  std::vector<Kernel> kernels;
  for (const ContinuousFactorPtr& closure : problem.closures) {
    kernels.push_back(soft_mixture_kernel(*closure, options.mixture));
  }
  RobustResult result = solve_kernels(problem, kernels, 0.5, options);
  result.method = "sum-mixture";
  return result;
}

}  // namespace hybrid
