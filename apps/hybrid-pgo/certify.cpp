// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "apps/hybrid-pgo/certify.h"

#include <utility>

#include "apps/hybrid-pgo/robust.h"

namespace hybrid {
namespace {

/// Poses of all relaxations that bound the joint objective, which limits their time.
constexpr int kBoundedPoses = 2000;

/// The active factors of a solution: all but those of loops that are not in force.
std::vector<ContinuousFactorPtr> factors_in_force(const Input& input,
                                                  const std::vector<Loop>& loops) {
  std::vector<ContinuousFactorPtr> factors;
  const std::vector<const Loop*> loop_of = loops_of_factors(input, loops);
  for (std::size_t f = 0; f < input.factors.size(); ++f) {
    if (loop_of[f] == nullptr || loop_of[f]->decision.in_force()) {
      factors.push_back(input.factors[f]);
    }
  }
  return factors;
}

/// Solves again from better poses.
Solution solve_from(const Values& values, Input input, Options options, std::vector<Loop>& loops) {
  input.initial = values;
  if (trusts_all(options)) {
    Solution solution = solve_batch(input, false, options.solver);
    loops = find_loops(input, solution.values, solution.decisions);
    return solution;
  }
  options.methods.portfolio.selection.trust_start = true;
  loops.clear();
  return solve_robust(input, options, loops);
}

/// Takes a solution from the staircase, with the counts and times of both.
void take(Solution from_staircase, const std::string& first_start, Solution& solution) {
  std::vector<StartTrial> starts = std::move(solution.starts);
  if (starts.empty()) starts.push_back({first_start, solution.cost, solution.iterations});
  starts.push_back({"staircase", from_staircase.cost, from_staircase.iterations});
  from_staircase.iterations += solution.iterations;
  from_staircase.seconds += solution.seconds;
  solution = std::move(from_staircase);
  solution.starts = std::move(starts);
  solution.start = "staircase";
}

}  // namespace

Solution solve_graph(const Input& input, const Options& options, std::vector<Loop>& loops) {
  if (!options.online) {
    return trusts_all(options) ? solve_batch(input, options.start == "auto", options.solver)
                               : solve_robust(input, options, loops);
  }
  return trusts_all(options) && input.graph.alternatives_count() == 0
             ? solve_online(input)
             : solve_selection(input, options.trusted, options.methods.online, options.report);
}

Certificate certify_solution(const Input& input, const Options& options, std::vector<Loop>& loops,
                             Solution& solution) {
  StaircaseResult climbed = climb_staircase(factors_in_force(input, loops), solution.values);
  if (!options.online && climbed.cost < climbed.cost_before) {
    std::vector<Loop> other_loops;
    Solution other = solve_from(climbed.values, input, options, other_loops);
    if (other.objective < solution.objective) {
      take(std::move(other), input.start, solution);
      loops = std::move(other_loops);
      climbed.certificate = certify(factors_in_force(input, loops), solution.values);
    }
  }
  if (options.online || trusts_all(options)) return climbed.certificate;
  const int budget = kBoundedPoses / static_cast<int>(input.poses().size());
  climbed.certificate.discrete_gap = discrete_gap(input, options, loops, solution.values, budget);
  return climbed.certificate;
}

}  // namespace hybrid
