// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/baselines/alternation.h"

#include "libhybrid/closures/closure_problem.h"
#include "libhybrid/core/elapsed.h"

namespace hybrid {

RobustResult solve_alternating(const RobustProblem& problem, const AlternationOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  const HybridGraph graph = mixture_graph(problem, options.mixture);

  // Closures are classified at the initial values, so that those rejected there do not enter the
  // sparsity.
  Assignment classified;
  std::size_t k = 0;
  graph.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    const std::vector<double> costs = factor->given(problem.initial)[0].costs();
    classified.set(closure_switch(k++).key, costs[1] < costs[0] ? 1 : 0);
  });
  const AlternatingResult solved =
      alternate(graph, {problem.initial, classified}, options.alternating);
  RobustResult result;
  result.method = "alternating";
  result.values = solved.estimate.values;
  result.converged = solved.report.status == AlternatingStatus::kConverged;
  result.message = solved.report.message;
  for (const HalfStep& step : solved.report.half_steps) {
    if (!step.discrete) result.iterations += step.changes;
    result.objectives.push_back(step.objective);
  }
  std::vector<bool> accepted;
  for (std::size_t c = 0; c < problem.closures.size(); ++c) {
    accepted.push_back(solved.estimate.assignment.at(closure_switch(c).key) == 0);
  }
  finish(problem, accepted, options.mixture, result);
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
