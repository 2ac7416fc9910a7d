// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/portfolio.h"

#include <utility>

#include "libhybrid/baselines/alternation.h"
#include "libhybrid/baselines/gnc.h"
#include "libhybrid/core/elapsed.h"
#include "libhybrid/solvers/chordal.h"

namespace hybrid {
namespace {

/// Re-admission from an answer: what its map agrees with is in at first.
RobustResult verified(const RobustProblem& problem, const Values& values,
                      const ClosureSelectionOptions& options) {
  RobustProblem from = problem;
  from.initial = values;
  ClosureSelectionOptions trusting = options;
  trusting.trust_start = true;
  return select_closures(from, trusting);
}

}  // namespace

PortfolioResult solve_portfolio(const RobustProblem& problem, const PortfolioOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  PortfolioResult portfolio;
  std::vector<RobustResult> answers;
  const auto add = [&](RobustResult raw, RobustResult checked, const std::string& name) {
    raw.method = name;
    portfolio.members.push_back({std::move(raw), checked.objective});
    answers.push_back(std::move(checked));
  };
  RobustResult nothing = select_closures(problem, options.escape);
  add(nothing, nothing, "escape");
  RobustResult given = verified(problem, problem.initial, options.escape);
  add(given, given, "escape from the start");
  std::vector<ContinuousFactorPtr> all = problem.trusted;
  all.insert(all.end(), problem.closures.begin(), problem.closures.end());
  RobustResult chordal =
      verified(problem, chordal_initialization(all, problem.initial), options.escape);
  add(chordal, chordal, "escape from chordal");
  AlternationOptions alternation;
  alternation.mixture = options.escape.mixture;
  alternation.alternating.continuous = options.escape.solver;
  alternation.alternating.continuous_iterations = options.escape.solver.max_iterations;
  RobustResult paper = solve_alternating(problem, alternation);
  add(paper, verified(problem, paper.values, options.escape), "alternating");
  if (options.gnc) {
    GncOptions gnc;
    gnc.mixture = options.escape.mixture;
    gnc.solver = options.escape.solver;
    RobustResult graduated = solve_gnc(problem, gnc);
    add(graduated, verified(problem, graduated.values, options.escape), "gnc");
  }
  std::size_t best = 0;
  for (std::size_t m = 1; m < answers.size(); ++m) {
    if (answers[m].objective < answers[best].objective) best = m;
  }
  portfolio.best = answers[best];
  portfolio.best.method = "portfolio";
  portfolio.best.iterations = 0;
  for (const RobustResult& answer : answers) portfolio.best.iterations += answer.iterations;
  portfolio.best.seconds = seconds_since(start);
  return portfolio;
}

}  // namespace hybrid
