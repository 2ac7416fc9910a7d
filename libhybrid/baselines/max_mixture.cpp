// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/baselines/max_mixture.h"

#include <algorithm>

namespace hybrid {

Kernel max_mixture_kernel(double outlier_variance, double offset) {
  const double weight = 1.0 / outlier_variance;
  return {[=](double s) { return std::min(s, weight * s + offset); },
          [=](double s) { return s <= weight * s + offset ? 1.0 : weight; }};
}

Kernel max_mixture_kernel(const ContinuousFactor& closure, const MixtureOptions& mixture) {
  const OutlierLine line = outlier_line(closure, mixture);
  return max_mixture_kernel(line.variance, line.offset);
}

RobustResult solve_max_mixture(const RobustProblem& problem, const ComparisonOptions& options) {
  std::vector<Kernel> kernels;
  for (const ContinuousFactorPtr& closure : problem.closures) {
    kernels.push_back(max_mixture_kernel(*closure, options.mixture));
  }
  RobustResult result = solve_kernels(problem, kernels, 1.0, options);
  result.method = "max-mixture";
  return result;
}

}  // namespace hybrid
