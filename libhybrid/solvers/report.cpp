// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/report.h"

namespace hybrid {

std::string to_string(SolverStatus status) {
  switch (status) {
    case SolverStatus::kConverged:
      return "converged";
    case SolverStatus::kIterationLimit:
      return "iteration limit";
    case SolverStatus::kUnderConstrained:
      return "under-constrained";
    case SolverStatus::kNotFinite:
      return "not finite";
    case SolverStatus::kStalled:
      break;
  }
  return "stalled";
}

}  // namespace hybrid
