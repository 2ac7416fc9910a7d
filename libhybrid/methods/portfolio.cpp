// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/methods/portfolio.h"

#include <utility>

#include "libhybrid/baselines/alternation.h"
#include "libhybrid/baselines/gnc.h"
#include "libhybrid/core/elapsed.h"
#include "libhybrid/solvers/chordal.h"

namespace hybrid {
namespace {

/// Loop closure selection from given values, starting with the closures that agree with them.
RobustResult verified(const RobustProblem& problem, const Values& values,
                      const ClosureSelectionOptions& options) {
  RobustProblem from = problem;
  from.initial = values;
  ClosureSelectionOptions trusting = options;
  trusting.trust_start = true;
  return select_closures(from, trusting);
}

}  // namespace

RobustResult solve_portfolio(const RobustProblem& problem, const PortfolioOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<MemberSummary> members;
  std::vector<RobustResult> answers;
  const auto add = [&](const RobustResult& raw, RobustResult checked, const std::string& name) {
    std::size_t accepted = 0;
    for (const ClosureDecision& decision : raw.decisions) accepted += decision.accepted() ? 1 : 0;
    members.push_back({name, raw.objective, checked.objective, accepted, raw.seconds});
    answers.push_back(std::move(checked));
  };
  const RobustResult nothing = select_closures(problem, options.selection);
  add(nothing, nothing, "selection");
  const RobustResult given = verified(problem, problem.initial, options.selection);
  add(given, given, "selection from the start");
  std::vector<ContinuousFactorPtr> all = problem.trusted;
  all.insert(all.end(), problem.closures.begin(), problem.closures.end());
  const RobustResult chordal =
      verified(problem, chordal_initialization(all, problem.initial), options.selection);
  add(chordal, chordal, "selection from chordal");
  AlternationOptions alternation;
  alternation.mixture = options.selection.mixture;
  alternation.alternating.continuous = options.selection.solver;
  alternation.alternating.continuous_iterations = options.selection.solver.max_iterations;
  const RobustResult paper = solve_alternating(problem, alternation);
  add(paper, verified(problem, paper.values, options.selection), "alternating");
  if (options.gnc) {
    GncOptions gnc;
    gnc.mixture = options.selection.mixture;
    gnc.solver = options.selection.solver;
    const RobustResult graduated = solve_gnc(problem, gnc);
    add(graduated, verified(problem, graduated.values, options.selection), "gnc");
  }
  std::size_t best = 0;
  for (std::size_t m = 1; m < answers.size(); ++m) {
    if (answers[m].objective < answers[best].objective) best = m;
  }
  RobustResult result = answers[best];
  result.method = "portfolio";
  result.members = std::move(members);
  result.iterations = 0;
  for (const RobustResult& answer : answers) result.iterations += answer.iterations;
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
