// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/solvers/options.h"

namespace HYBRID_API hybrid {

/// Minimises the joint objective over the continuous values of an estimate, starting at them and
/// with its assignment fixed (eq. 8b); returns the objective reached.
using ContinuousSolver = std::function<double(const HybridGraph&, Estimate&)>;

struct ExhaustiveResult {
  Estimate estimate;               ///< the best of all
  double objective = 0.0;          ///< of that estimate; +infinity if nothing is possible
  std::vector<DiscreteKey> keys;   ///< as HybridGraph::discrete_keys
  std::vector<double> objectives;  ///< by joint value of `keys`, row-major
};

/// The joint minimum by trying every assignment, each from the same initial values: a reference for
/// small graphs. Throws Error for more than `max_assignments` joint values.
ExhaustiveResult solve_exhaustive(const HybridGraph& graph, const Values& initial,
                                  const ContinuousSolver& solver,
                                  std::size_t max_assignments = 100000);

/// The same with Levenberg-Marquardt; for an assignment without convergence the objective reached
/// is taken.
ExhaustiveResult solve_exhaustive(const HybridGraph& graph, const Values& initial,
                                  const SolverOptions& options = {});

}  // namespace hybrid
