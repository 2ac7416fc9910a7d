// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/core/values.h"
#include "libhybrid/linear/schur.h"
#include "libhybrid/solvers/report.h"

namespace HYBRID_API hybrid {

/// Options of the continuous solvers: when they stop, and how they start.
struct SolverOptions {
  int max_iterations = 100;
  /// Converged once the decrease of the cost that the whole Gauss-Newton step, neither damped nor
  /// shortened, predicts (half the squared Newton decrement) is at most this share of the cost, and
  /// so is the actual decrease. This criterion depends on no frame and no unit.
  double relative_decrease = 1e-6;
  /// Converged once the gradient |g| of no variable, divided by the Frobenius norm of its Jacobian
  /// (so that it counts in standard deviations), exceeds this.
  double gradient = 1e-9;
  /// Converged once the whole Gauss-Newton step of no variable, times that norm, exceeds this.
  double step = 1e-9;
  /// Levenberg-Marquardt: damping of the first step, relative to the diagonal of the Hessian. Zero
  /// is a Gauss-Newton step, best for initial poses from odometry. SolverReport::damping of a solve
  /// that met its iteration limit resumes that solve.
  double initial_damping = 0.0;
  /// Dogleg: radius of the first step, in standard deviations per unknown (root mean square).
  double initial_radius = 1e4;
  /// solve_from_starts: multiplications and additions of all factorisations together; 0: any. At
  /// least one system is solved from each start.
  double max_operations = 0.0;
  Elimination elimination = Elimination::kAutomatic;
  int threads = 0;  ///< 0: one per core, at most 4; the result is the same for any number
};

struct SolverResult {
  Values values;
  SolverReport report;
};

}  // namespace hybrid
