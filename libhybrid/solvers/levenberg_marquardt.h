// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/solvers/options.h"
#include "libhybrid/solvers/problem.h"

namespace HYBRID_API hybrid {

/// Minimises the continuous variables for a fixed assignment (eq. 8b) by Levenberg-Marquardt with
/// damping relative to the diagonal of the Hessian. A step is accepted only if the cost falls.
SolverResult levenberg_marquardt(const HybridGraph& graph, const Estimate& initial,
                                 const SolverOptions& options = {});

/// The same on a compiled problem, from `state` and into it.
SolverReport levenberg_marquardt(Problem& problem, Problem::State& state,
                                 const SolverOptions& options = {});

}  // namespace hybrid
