// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/closures/problem.h"
#include "libhybrid/selection/closure_selection.h"

namespace HYBRID_API hybrid {

struct PortfolioOptions {
  ClosureSelectionOptions escape;
  bool gnc = true;  ///< the slowest member
};

/// What one member of the portfolio ended with.
struct PortfolioMember {
  RobustResult result;
  /// Joint objective once the closures that the evidence contradicts, or does not carry, have been
  /// dropped from the member's answer: members are compared by this, for the objective alone would
  /// reward false closures that agree with each other.
  double objective = 0.0;
};

struct PortfolioResult {
  RobustResult best;
  std::vector<PortfolioMember> members;
};

/// Several methods and starts: alternation, re-admission from nothing, from the closures that agree
/// with the initial values and from those that agree with a chordal start, GNC. The answers that
/// are not of re-admission are verified by it; the lowest joint objective wins.
PortfolioResult solve_portfolio(const RobustProblem& problem, const PortfolioOptions& options = {});

}  // namespace hybrid
