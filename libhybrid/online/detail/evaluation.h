// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <utility>
#include <vector>

#include "libhybrid/closures/problem.h"
#include "libhybrid/core/paced_task.h"
#include "libhybrid/selection/selection_options.h"
#include "libhybrid/smoother/incremental.h"

namespace hybrid {

/// Selects among the closures of a problem from scratch, or from its initial values where those
/// `accepted` have far less noise there: the selection from scratch has then accepted false
/// closures within overstated noise.
RobustResult evaluate_closures(const RobustProblem& problem, const std::vector<bool>& accepted,
                               const ClosureSelectionOptions& options);

/// An evaluation of all closures there were when it began, while the map goes on.
struct ClosureEvaluation {
  ClosureEvaluation(RobustProblem all, std::vector<bool> in,
                    const ClosureSelectionOptions& settings)
      : problem(std::move(all)), accepted(std::move(in)), options(settings) {}

  RobustProblem problem;
  std::vector<bool> accepted;
  ClosureSelectionOptions options;
  RobustResult result;
  bool adopted = false;
  PacedTask task{[this] { result = evaluate_closures(problem, accepted, options); }};
};

/// The result of an evaluation for a map that has grown since: variables that it does not know move
/// as the poses do that they were measured from.
Values grown(const Values& result, const IncrementalSmoother& smoother);

}  // namespace hybrid
