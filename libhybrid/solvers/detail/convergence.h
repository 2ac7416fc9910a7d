// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/solvers/options.h"
#include "libhybrid/solvers/problem.h"

namespace hybrid {

/// Largest gradient of a variable in standard deviations, see SolverOptions::gradient; not a number
/// if a residual or a Jacobian is none.
double gradient_norm(const NormalEquations& system);

/// Largest step of a variable in standard deviations, see SolverOptions::step.
double step_norm(const NormalEquations& system, const std::vector<double>& step);

/// Whether a solve may end at `state`. Variables found undetermined on the way are checked again
/// there, with the problem linearised and assembled at `state`. If none is undetermined any more,
/// the report drops them, and the solve must continue without the damping of the singular system. A
/// solve that ends at its start checks here for the first time, and may end.
bool is_settled(Problem& problem, const Problem::State& state, SolverReport& report);

/// What a solve has come to that finds no step which lowers the cost: the end, where the cost
/// changes along the gradient as that says, to rounding; else a Jacobian is wrong. The gradient is
/// that of the state.
SolverStatus status_without_decrease(Problem& problem, const Problem::State& state, double cost);

/// Sets status and message; a solve that met a singular system is under-constrained, however it
/// ended.
void finish_report(SolverStatus status, SolverReport& report);

/// One sentence on how a solve ended.
std::string describe(const SolverReport& report);

/// Compiles a graph, runs solve(problem, state, options) and puts the state back into values.
template <class Solve>
SolverResult solve_graph(const HybridGraph& graph, const Estimate& initial,
                         const SolverOptions& options, const Solve& solve) {
  const auto start = std::chrono::steady_clock::now();
  Problem problem(graph, initial.values, initial.assignment, options.threads,
                  WeakComponents::kUncoupled, options.elimination);
  const double analysis = seconds_since(start);
  Problem::State state = problem.load(initial.values);
  SolverResult result{initial.values, solve(problem, state, options)};
  problem.store(state, result.values);
  result.report.analysis_seconds = analysis;
  result.report.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
