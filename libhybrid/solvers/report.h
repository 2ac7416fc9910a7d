// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>
#include <vector>

#include "libhybrid/core/key.h"

namespace HYBRID_API hybrid {

/// How a solve ended. The estimate is never worse than the start.
enum class SolverStatus {
  kConverged,  ///< at a stationary point, by the criteria of SolverOptions
  kIterationLimit,
  kUnderConstrained,  ///< the factors leave some variables undetermined; the report names them
  kNotFinite,         ///< the objective or a derivative is not a finite number
  kStalled            ///< no step lowers the objective, however short: a Jacobian may be wrong
};

std::string to_string(SolverStatus status);

/// Report of a continuous solve (eq. 8b).
struct SolverReport {
  SolverStatus status = SolverStatus::kConverged;
  int iterations = 0;         ///< linear systems solved
  std::vector<double> costs;  ///< at the start and after each accepted step; never rising
  double final_cost() const { return costs.empty() ? 0.0 : costs.back(); }
  double seconds = 0.0;
  double analysis_seconds = 0.0;  ///< part of `seconds` spent on compiling the sparsity
  double damping = 0.0;           ///< Levenberg-Marquardt: that of the next step
  std::string message;
  /// Variables in the null space of a singular system, those that move most first.
  std::vector<Key> under_constrained;
};

/// The joint objective of eq. 6 after one half-step of the alternation.
struct HalfStep {
  bool discrete = false;
  double objective = 0.0;
  int changes = 0;  ///< discrete variables that changed value, or iterations of the solver
};

/// The alternation has the status of its last continuous half-step, once no discrete variable
/// changes any more, or kIterationLimit at the limit of pairs.
using AlternatingStatus = SolverStatus;

/// Report of an alternation. The objective of `half_steps` never rises (eq. 10), from
/// `initial_objective` on.
struct AlternatingReport {
  AlternatingStatus status = AlternatingStatus::kConverged;
  int iterations = 0;  ///< pairs of half-steps
  double initial_objective = 0.0;
  double objective = 0.0;
  double cost = 0.0;  ///< half the weighted squared error
  std::vector<HalfStep> half_steps;
  bool discrete_exact = true;  ///< false if local search replaced elimination
  int analyses = 0;            ///< how often the sparsity was analysed
  SolverReport last_solve;     ///< of the last continuous half-step
  double seconds = 0.0;
  std::string message;
};

}  // namespace hybrid
