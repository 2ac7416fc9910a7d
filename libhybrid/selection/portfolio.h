// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/problem.h"
#include "libhybrid/selection/closure_selection.h"

namespace HYBRID_API hybrid {

struct PortfolioOptions {
  ClosureSelectionOptions selection;
  bool gnc = true;  ///< the slowest member
};

/// Several methods and starts: alternation, re-admission from nothing, from the closures that agree
/// with the initial values and from those that agree with a chordal start, GNC. The answers that
/// are not of re-admission are verified by it; the lowest joint objective wins. The result tells
/// what each member ended with.
RobustResult solve_portfolio(const RobustProblem& problem, const PortfolioOptions& options = {});

}  // namespace hybrid
