// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/discrete/inference.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/solvers/options.h"
#include "libhybrid/solvers/problem.h"

namespace HYBRID_API hybrid {

struct AlternatingOptions {
  int max_iterations = 100;  ///< pairs of half-steps
  /// Converged once a pair of half-steps lowers the joint objective by at most this share of the
  /// cost, no discrete variable changed and the continuous half-step did not end at its iteration
  /// limit.
  double relative_decrease = 1e-6;
  /// Iterations of each continuous half-step, instead of continuous.max_iterations; it need not
  /// reach the minimum for eq. 10 to hold, and the next one continues from its result.
  int continuous_iterations = 100;
  SolverOptions continuous;  ///< of the continuous half-steps
  DiscreteOptions discrete;
};

struct AlternatingResult {
  Estimate estimate;
  AlternatingReport report;
};

/// Alternating minimisation of the joint objective (eq. 8-10): the exact discrete half-step given
/// the continuous values, then Levenberg-Marquardt given the assignment, until neither changes and
/// the latter converged (or cannot: see AlternatingStatus). The objective falls or stays at every
/// half-step; ties keep the incumbent assignment.
AlternatingResult alternate(const HybridGraph& graph, const Estimate& initial,
                            const AlternatingOptions& options = {});

/// The same on a compiled problem of that graph, in place.
AlternatingReport alternate(const HybridGraph& graph, Problem& problem, Problem::State& state,
                            Assignment& assignment, const AlternatingOptions& options = {});

}  // namespace hybrid
