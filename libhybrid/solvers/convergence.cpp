// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/detail/convergence.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libhybrid/solvers/null_space.h"

namespace hybrid {

double gradient_norm(const NormalEquations& system) {
  const BlockMatrix& H = system.matrix();
  double largest = 0.0;
  for (int p = 0; p < H.size(); ++p) {
    double square = 0.0;
    for (int i = H.start(p); i < H.start(p) + H.dim(p); ++i) {
      square += system.gradient()[i] * system.gradient()[i];
    }
    if (!std::isfinite(square)) return std::numeric_limits<double>::quiet_NaN();
    // A variable with a zero Jacobian has neither gradient nor scale.
    if (square > 0.0) largest = std::max(largest, square / system.scale(p));
  }
  return std::sqrt(largest);
}

double step_norm(const NormalEquations& system, const std::vector<double>& step) {
  const BlockMatrix& H = system.matrix();
  double largest = 0.0;
  for (int p = 0; p < H.size(); ++p) {
    double square = 0.0;
    for (int i = H.start(p); i < H.start(p) + H.dim(p); ++i) square += step[i] * step[i];
    largest = std::max(largest, square * system.scale(p));
  }
  return std::sqrt(largest);
}

bool is_settled(Problem& problem, const Problem::State& state, SolverReport& report) {
  const bool at_start = report.iterations == 0;
  if (report.under_constrained.empty() && !at_start) return true;
  problem.linearize(state);
  problem.assemble();
  report.under_constrained = factorize_undamped(problem).free;
  return at_start || !report.under_constrained.empty();
}

SolverStatus status_without_decrease(Problem& problem, const Problem::State& state, double cost) {
  constexpr double kProbe = 1e-4;      // standard deviations
  constexpr double kRounding = 1e-14;  // of the cost
  constexpr double kAgrees = 0.1;
  const NormalEquations& system = problem.system();
  const std::vector<double>& g = system.gradient();
  std::vector<double> step(g.size());
  for (std::size_t i = 0; i < g.size(); ++i) {
    step[i] = g[i] == 0.0 ? 0.0 : -g[i] / system.diagonal()[i];
  }
  const double norm = step_norm(system, step);
  if (!(norm > 0.0)) return SolverStatus::kConverged;
  double slope = 0.0;
  for (std::size_t i = 0; i < g.size(); ++i) {
    step[i] *= kProbe / norm;
    slope += step[i] * g[i];
  }
  Problem::State there;
  problem.retract(state, step.data(), there);
  double change = problem.cost(there);
  for (double& x : step) x = -x;
  problem.retract(state, step.data(), there);
  change = 0.5 * (change - problem.cost(there));
  const double most = kAgrees * std::abs(slope) + kRounding * cost;
  return std::abs(change - slope) <= most ? SolverStatus::kConverged : SolverStatus::kStalled;
}

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
      return "cost or derivatives are not finite" + after +
             ": a value or a measurement is NaN or infinite, or a factor is not defined there";
    case SolverStatus::kStalled:
      break;
  }
  return "no step lowers the cost" + after + ": a Jacobian may be wrong";
}

}  // namespace hybrid
