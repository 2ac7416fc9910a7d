// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/closures/problem.h"

namespace HYBRID_API hybrid {

/// A lower bound on the joint objective of a robust problem.
struct ObjectiveBound {
  /// No poses and no decisions have a lower objective (eq. 6 under the mixture of eq. 17).
  double bound = 0.0;
  double gap = 0.0;       ///< objective of the given estimate minus the bound, not negative
  int solves = 0;         ///< relaxations solved
  bool complete = false;  ///< the search ended before the budget
};

/// Bounds the joint objective by branch and bound over the decisions. A node decides some closures.
/// The relative poses that are then in force, trusted or accepted, cost at least the minimum of the
/// isotropic problem of lower weights, which its dual certificate bounds (see certify); a rejected
/// closure costs at least the constant of the outlier model; an undecided one at least the smaller
/// of this and of zero. The node of least bound is split at the closure with the largest residual.
/// Small problems are enumerated as far as their bounds require; after `budget` relaxations (with
/// 0, without any) the least bound of all open nodes is returned, which is valid, too. The bound
/// includes the slack of the isotropic problem, and of
/// relative poses under a robust loss, which count as nothing, so the gap is rarely zero. Throws
/// Error if a factor over several variables is no relative pose.
ObjectiveBound bound_objective(const RobustProblem& problem, const Values& values,
                               const std::vector<bool>& accepted, const MixtureOptions& mixture,
                               int budget);

}  // namespace hybrid
