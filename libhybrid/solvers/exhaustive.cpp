// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/exhaustive.h"

#include <string>
#include <utility>

#include "libhybrid/core/infinity.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

Assignment nth_assignment(const std::vector<DiscreteKey>& keys, std::size_t n) {
  Assignment assignment;
  set_joint(keys, n, assignment);
  return assignment;
}

double discrete_cost(const HybridGraph& graph, const Assignment& assignment) {
  double sum = 0.0;
  graph.discrete().for_each([&](Handle, const Table& table) { sum += table.cost(assignment); });
  return sum;
}

}  // namespace

ExhaustiveResult solve_exhaustive(const HybridGraph& graph, const Values& initial,
                                  const ContinuousSolver& solver, std::size_t max_assignments) {
  ExhaustiveResult result;
  result.keys = graph.discrete_keys();
  const std::size_t count = joint_size(result.keys);
  if (count > max_assignments) {
    throw Error("an exhaustive solve of " + std::to_string(result.keys.size()) +
                " discrete variables would try " + std::to_string(count) +
                " assignments, beyond the limit of " + std::to_string(max_assignments));
  }
  result.objectives.assign(count, kInfinity);
  result.objective = kInfinity;
  result.estimate = {initial, nth_assignment(result.keys, 0)};
  for (std::size_t n = 0; n < count; ++n) {
    Estimate estimate{initial, nth_assignment(result.keys, n)};
    if (discrete_cost(graph, estimate.assignment) == kInfinity) continue;
    result.objectives[n] = solver(graph, estimate);
    if (!(result.objectives[n] < result.objective)) continue;
    result.objective = result.objectives[n];
    result.estimate = std::move(estimate);
  }
  return result;
}

ExhaustiveResult solve_exhaustive(const HybridGraph& graph, const Values& initial,
                                  const SolverOptions& options) {
  const ContinuousSolver solver = [&](const HybridGraph& g, Estimate& estimate) {
    estimate.values = levenberg_marquardt(g, estimate, options).values;
    return objective(g, estimate.values, estimate.assignment);
  };
  return solve_exhaustive(graph, initial, solver);
}

}  // namespace hybrid
