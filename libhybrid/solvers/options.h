// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/core/values.h"
#include "libhybrid/linear/schur.h"
#include "libhybrid/solvers/report.h"

namespace hybrid {

/// When the continuous solvers stop, and how they start.
struct SolverOptions {
  int max_iterations = 100;
  /// Converged once an accepted step lowers the cost by less than this share of it.
  double relative_decrease = 1e-6;
  /// Converged once no entry of the gradient, divided by the root of the diagonal of the Hessian
  /// (so that it counts in standard deviations), exceeds this.
  double gradient = 1e-9;
  /// Converged once no entry of the step, times the root of the diagonal of the Hessian, exceeds
  /// this.
  double step = 1e-9;
  /// Levenberg-Marquardt: damping of the first step, relative to the diagonal of the Hessian. Zero
  /// is a Gauss-Newton step, which poses chained from odometry want.
  double initial_damping = 0.0;
  /// Dogleg: radius of the first step, in standard deviations per unknown (root mean square).
  double initial_radius = 1e4;
  Elimination elimination = Elimination::kAutomatic;
  int threads = 0;  ///< 0: one per core, at most 4; the result is the same for any number
};

struct SolverResult {
  Values values;
  SolverReport report;
};

}  // namespace hybrid
