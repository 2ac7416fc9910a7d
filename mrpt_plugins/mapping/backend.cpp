// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/backend.h"

#include "mrpt_plugins/mapping/batch_backend.h"

namespace hybrid {

std::unique_ptr<Backend> make_backend(IniSection solver) {
  solver.choice("mode", "batch", {"batch"},
                "batch: the whole graph at once, by alternating minimisation");
  AlternatingOptions options;
  options.max_iterations =
      solver.get("max_iterations", options.max_iterations,
                 "pairs of a discrete and a continuous half-step", IniRange{1, 1e6});
  options.relative_decrease =
      solver.get("relative_decrease", options.relative_decrease,
                 "converged once a pair of half-steps lowers the objective by less than this share "
                 "of the cost",
                 kPositive);
  options.continuous.max_iterations =
      solver.get("linear_solves", options.continuous.max_iterations,
                 "at most, in one continuous half-step", IniRange{1, 1e6});
  options.continuous.threads = solver.get("threads", options.continuous.threads,
                                          "0: as many as there are cores, at most 4; the result "
                                          "is the same",
                                          IniRange{0, 256});
  const int solve_every =
      solver.get("solve_every", 0, "keyframes between solves on the way; 0: one solve at the end",
                 kNonNegative);
  return std::make_unique<BatchBackend>(options, solve_every);
}

}  // namespace hybrid
