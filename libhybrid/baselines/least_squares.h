// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/closure_problem.h"

namespace HYBRID_API hybrid {

/// Levenberg-Marquardt that accepts every closure.
RobustResult solve_lm(const RobustProblem& problem, const ComparisonOptions& options = {});

/// The same with only the given closures accepted: none for dead reckoning, the true ones for a
/// bound that no method can beat. Throws Error unless there is one entry per closure.
RobustResult solve_given(const RobustProblem& problem, const std::vector<bool>& accepted,
                         const ComparisonOptions& options = {});

}  // namespace hybrid
