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

/// Several methods and starts: alternation, loop closure selection from no closures, from those
/// that agree with the initial values and from those that agree with chordal initial values, and
/// GNC. The results of alternation and GNC are verified by loop closure selection; the lowest joint
/// objective wins. `members` of the result has a summary of each.
RobustResult solve_portfolio(const RobustProblem& problem, const PortfolioOptions& options = {});

}  // namespace hybrid
