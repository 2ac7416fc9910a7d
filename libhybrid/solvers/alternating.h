// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/discrete/inference.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/solvers/options.h"
#include "libhybrid/solvers/problem.h"

namespace HYBRID_API hybrid {

struct AlternatingOptions {
  int max_iterations = 100;
  /// Besides, no discrete variable changed and the continuous half-step did not end at its limit.
  double relative_decrease = 1e-6;
  /// Instead of continuous.max_iterations: a half-step need not reach the minimum for eq. 10 to
  /// hold, and the next one continues from its result.
  int continuous_iterations = 100;
  SolverOptions continuous;
  DiscreteOptions discrete;

  template <class Table>
  static void describe(Table& table) {
    using O = AlternatingOptions;
    table.option("max_iterations", &O::max_iterations, {1, 1e6},
                 "at most so many pairs of a discrete and a continuous half-step");
    table.option("relative_decrease", &O::relative_decrease, {1e-15, 1},
                 "converged once a pair of half-steps lowers the objective by less than this share "
                 "of the cost");
    table.option("continuous_iterations", &O::continuous_iterations, {1, 1e6},
                 "linear systems solved in one continuous half-step, at most", "linear_solves");
    table.field("continuous", &O::continuous, "settings of the continuous half-steps");
    table.field("discrete", &O::discrete, "settings of the discrete half-steps");
  }
};

struct AlternatingResult {
  Estimate estimate;
  AlternatingReport report;
};

/// Alternating minimisation of the joint objective (eq. 8-10): the exact discrete half-step given
/// the continuous values, then Levenberg-Marquardt given the assignment, until neither changes and
/// the latter converged (or cannot: see AlternatingStatus). The objective falls or stays at every
/// half-step; ties keep the incumbent assignment. Where no joint value is possible, the status is
/// kNotFinite and the message names the variables.
AlternatingResult alternate(const HybridGraph& graph, const Estimate& initial,
                            const AlternatingOptions& options = {});

/// The same on a compiled problem of that graph, in place.
AlternatingReport alternate(const HybridGraph& graph, Problem& problem, Problem::State& state,
                            Assignment& assignment, const AlternatingOptions& options = {});

}  // namespace hybrid
