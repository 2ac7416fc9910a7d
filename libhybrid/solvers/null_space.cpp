// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/solvers/null_space.h"

#include <algorithm>

namespace hybrid {
namespace {

constexpr std::size_t kNamedInMessage = 5;

}  // namespace

std::vector<FreeVariable> free_variables(const HybridGraph& graph, const Estimate& estimate,
                                         WeakComponents weak) {
  Problem problem(graph, estimate.values, estimate.assignment, 1, weak);
  problem.linearize(problem.load(estimate.values));
  return free_variables(problem, problem.extended_factor());
}

std::vector<FreeVariable> free_variables(const Problem& problem, const ExtendedCholesky& factor) {
  std::vector<int> blocks;
  for (int b = 0; b < problem.block_count(); ++b) {
    if (factor.free_directions(b).cols() > 0) blocks.push_back(b);
  }
  std::stable_sort(blocks.begin(), blocks.end(),
                   [&](int a, int b) { return factor.motion(a) > factor.motion(b); });
  std::vector<FreeVariable> result;
  for (int b : blocks) result.push_back({problem.key(b), factor.free_directions(b)});
  return result;
}

bool is_clearly_regular(Problem& problem) {
  return problem.factorize(0.0) < 0 && problem.system().smallest_pivot_ratio() >= kSuspiciousPivot;
}

Undamped factorize_undamped(Problem& problem) {
  Undamped result;
  result.usable = problem.factorize(0.0) < 0;
  if (result.usable && problem.system().smallest_pivot_ratio() >= kSuspiciousPivot) return result;
  for (const FreeVariable& variable : free_variables(problem, problem.extended_factor())) {
    result.free.push_back(variable.key);
  }
  result.usable = result.usable && result.free.empty();
  return result;
}

std::string under_constrained_message(const std::vector<Key>& keys) {
  std::string names;
  for (std::size_t i = 0; i < std::min(keys.size(), kNamedInMessage); ++i) {
    names += (i == 0 ? "" : ", ") + to_string(keys[i]);
  }
  if (keys.size() > kNamedInMessage) names += ", ...";
  return "the factors leave " + names + " (" + std::to_string(keys.size()) +
         (keys.size() == 1 ? " variable" : " variables") +
         ") undetermined: add a prior or measurements that hold them";
}

}  // namespace hybrid
