// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/baselines/least_squares.h"

#include "libhybrid/core/elapsed.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {

RobustResult solve_lm(const RobustProblem& problem, const ComparisonOptions& options) {
  RobustResult result =
      solve_given(problem, std::vector<bool>(problem.closures.size(), true), options);
  result.method = "lm";
  return result;
}

RobustResult solve_given(const RobustProblem& problem, const std::vector<bool>& accepted,
                         const ComparisonOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  if (accepted.size() != problem.closures.size()) {
    throw Error(std::to_string(accepted.size()) + " decisions for " +
                std::to_string(problem.closures.size()) + " closures");
  }
  const HybridGraph graph(factors_in_force(problem, accepted));
  const SolverResult solved = levenberg_marquardt(graph, {problem.initial, {}}, options.solver);
  RobustResult result;
  result.method = "given";
  result.values = solved.values;
  result.iterations = solved.report.iterations;
  result.converged = solved.report.status == SolverStatus::kConverged;
  result.message = solved.report.message;
  finish(problem, accepted, options.mixture, result);
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
