// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string>
#include <vector>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/solvers/options.h"
#include "libhybrid/solvers/problem.h"

namespace hybrid {

/// Largest entry of the gradient in standard deviations, see SolverOptions::gradient.
inline double gradient_norm(const NormalEquations& system) {
  double square = 0.0;
  for (int i = 0; i < system.scalars(); ++i) {
    const double g = system.gradient()[i];
    square = std::max(square, g * g / system.diagonal()[i]);
  }
  return std::sqrt(square);
}

/// Largest entry of a step in standard deviations, see SolverOptions::step.
inline double step_norm(const NormalEquations& system, const std::vector<double>& step) {
  double square = 0.0;
  for (int i = 0; i < system.scalars(); ++i) {
    square = std::max(square, step[i] * step[i] * system.diagonal()[i]);
  }
  return std::sqrt(square);
}

/// Predicted decreases below this share of the cost are lost in rounding.
inline constexpr double kNegligibleDecrease = 1e-14;

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
