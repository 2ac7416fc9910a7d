// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/closure_problem.h"

namespace HYBRID_API hybrid {

/// A closure under the sum of its two components: rho(s) = -2 log(exp(-s / 2) +
/// exp(-(s / variance + offset) / 2)), less its value at zero, where `offset` is twice what the
/// outlier component costs more at a zero residual. Its weight is that of expectation-maximisation.
Kernel soft_mixture_kernel(double outlier_variance, double offset);

/// The kernel for a closure under the mixture of eq. 17.
Kernel soft_mixture_kernel(const ContinuousFactor& closure, const MixtureOptions& mixture);

/// Sum-mixtures (footnote 4): like `solve_max_mixture`, but no component is chosen; each counts by
/// its probability. Accepted are the closures that are inliers with probability one half or more at
/// the end.
RobustResult solve_soft_mixture(const RobustProblem& problem,
                                const ComparisonOptions& options = {});

}  // namespace hybrid
