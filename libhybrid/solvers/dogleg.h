// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/solvers/options.h"
#include "libhybrid/solvers/problem.h"

namespace HYBRID_API hybrid {

/// Minimises the continuous variables for a fixed assignment (eq. 8b) by Powell's dogleg: inside a
/// trust region, the path from the steepest descent to the Gauss-Newton step, lengths measured by
/// the diagonal of the Hessian. A rejected step costs no new factorisation.
SolverResult dogleg(const HybridGraph& graph, const Estimate& initial,
                    const SolverOptions& options = {});

/// The same on a compiled problem, from `state` and into it.
SolverReport dogleg(Problem& problem, Problem::State& state, const SolverOptions& options = {});

}  // namespace hybrid
