// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/core/option.h"
#include "libhybrid/core/values.h"
#include "libhybrid/linear/schur.h"
#include "libhybrid/solvers/report.h"

namespace HYBRID_API hybrid {

/// Options of the continuous solvers: when they stop, and how they start.
struct SolverOptions {
  int max_iterations = 100;
  /// The whole step is neither damped nor shortened: it predicts a decrease of half the squared
  /// Newton decrement, and the actual one must be as small. This depends on no frame and no unit.
  double relative_decrease = 1e-6;
  double gradient = 1e-9;
  double step = 1e-9;
  /// Zero is a Gauss-Newton step, best for initial poses from odometry. SolverReport::damping of a
  /// solve that met its iteration limit resumes that solve.
  double initial_damping = 0.0;
  double initial_radius = 1e4;
  /// solve_from_starts: multiplications and additions of all factorisations together; 0: any. At
  /// least one system is solved from each start.
  double max_operations = 0.0;
  Elimination elimination = Elimination::kAutomatic;
  int threads = 0;

  template <class Table>
  static void describe(Table& table) {
    using O = SolverOptions;
    table.option("max_iterations", &O::max_iterations, {1, 1e6}, "linear systems solved at most");
    table.option("relative_decrease", &O::relative_decrease, {1e-15, 1e-2},
                 "converged once a whole Gauss-Newton step promises to lower the cost by less than "
                 "this share");
    table.field("gradient", &O::gradient,
                "converged once the gradient of no variable, divided by the Frobenius norm of its "
                "Jacobian, exceeds this [standard deviations]");
    table.field("step", &O::step,
                "converged once the whole step of no variable, times that norm, exceeds this "
                "[standard deviations]");
    table.field(
        "initial_damping", &O::initial_damping,
        "of the first step of Levenberg-Marquardt, relative to the diagonal of the Hessian");
    table.field(
        "initial_radius", &O::initial_radius,
        "of the first step of the dogleg, root mean square of all unknowns [standard deviations]");
    table.option("threads", &O::threads, {0, 256},
                 "threads; 0: one per core, at most 4; the result is the same for any number");
  }
};

struct SolverResult {
  Values values;
  SolverReport report;
};

}  // namespace hybrid
