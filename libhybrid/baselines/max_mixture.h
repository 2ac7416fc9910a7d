// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/closure_problem.h"

namespace HYBRID_API hybrid {

/// A closure under the likelier of its two components at every evaluation (Olson and Agarwal, 2013,
/// eq. 6): rho(s) = min(s, s / variance + offset), where `offset` is twice the additional cost of
/// the outlier component at a zero residual.
Kernel max_mixture_kernel(double outlier_variance, double offset);

/// The kernel for a closure of `rows` residuals under the mixture of eq. 17.
Kernel max_mixture_kernel(const ContinuousFactor& closure, const MixtureOptions& mixture);

/// Max-mixtures: Levenberg-Marquardt that chooses components anew at every evaluation. Closures
/// whose inlier component is the likelier one at the end are accepted.
RobustResult solve_max_mixture(const RobustProblem& problem, const ComparisonOptions& options = {});

}  // namespace hybrid
