// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/convergence.h"

#include "libhybrid/solvers/null_space.h"

namespace hybrid {

void finish_report(SolverStatus status, SolverReport& report) {
  report.status = status;
  if (status != SolverStatus::kNotFinite && !report.under_constrained.empty()) {
    report.status = SolverStatus::kUnderConstrained;
  }
  report.message = describe(report);
}

std::string describe(const SolverReport& report) {
  const std::string after = " after " + std::to_string(report.iterations) + " iterations";
  switch (report.status) {
    case SolverStatus::kConverged:
      return "converged" + after;
    case SolverStatus::kIterationLimit:
      return "not converged" + after + ", the limit";
    case SolverStatus::kUnderConstrained:
      return under_constrained_message(report.under_constrained);
    case SolverStatus::kNotFinite:
      return "the cost of the initial estimate is not finite: a value or a measurement is NaN or "
             "infinite";
    case SolverStatus::kStalled:
      break;
  }
  return "no step lowers the cost" + after + ": a Jacobian may be wrong";
}

}  // namespace hybrid
