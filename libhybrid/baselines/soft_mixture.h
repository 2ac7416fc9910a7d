// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/closure_problem.h"

namespace HYBRID_API hybrid {

/// A closure under the sum of its two components: rho(s) = -2 log(exp(-s / 2) + exp(-(s / variance
/// + offset) / 2)), less its value at zero, where `offset` is twice the additional cost of the
/// outlier component at a zero residual. Its weight is that of expectation-maximisation.
Kernel soft_mixture_kernel(double outlier_variance, double offset);

/// The kernel for a closure under the mixture of eq. 17.
Kernel soft_mixture_kernel(const ContinuousFactor& closure, const MixtureOptions& mixture);

/// Sum-mixtures (footnote 4): like `solve_max_mixture`, but each component is weighted by its
/// probability rather than chosen. Closures with a final inlier probability of one half or more are
/// accepted.
RobustResult solve_soft_mixture(const RobustProblem& problem,
                                const ComparisonOptions& options = {});

}  // namespace hybrid
