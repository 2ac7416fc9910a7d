// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/closure_problem.h"

namespace HYBRID_API hybrid {

struct DcsOptions : ComparisonOptions {
  double phi = 1.0;  ///< squared whitened norms beyond it are scaled down
};

/// s = min(1, 2 phi / (phi + chi2)), by which dynamic covariance scaling multiplies residual and
/// Jacobian (Agarwal et al., 2013, eq. 15).
double dcs_scale(double chi_square, double phi);

/// The kernel whose weight is s^2: chi2 up to phi, then phi (3 chi2 - phi) / (chi2 + phi).
Kernel dcs_kernel(double phi);

/// Dynamic covariance scaling: closures under that kernel; those with a final s of at least one
/// half are accepted. Throws Error unless phi is positive.
RobustResult solve_dcs(const RobustProblem& problem, const DcsOptions& options = {});

}  // namespace hybrid
