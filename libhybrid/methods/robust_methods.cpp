// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/methods/robust_methods.h"

#include "libhybrid/baselines/least_squares.h"
#include "libhybrid/baselines/max_mixture.h"
#include "libhybrid/baselines/soft_mixture.h"
#include "libhybrid/core/error.h"
#include "libhybrid/methods/solve_online.h"

namespace hybrid {
namespace {

using Task = RobustTask;
using Options = MethodOptions;

RobustResult solve_dead_reckoning(const Task& task, const Options& options) {
  const std::vector<bool> none(task.problem.closures.size(), false);
  return solve_given(task.problem, none, options.common);
}

RobustResult solve_oracle(const Task& task, const Options& options) {
  if (task.truth.size() != task.problem.closures.size()) {
    throw Error("the oracle needs to know which closures are true");
  }
  return solve_given(task.problem, task.truth, options.common);
}

RobustResult solve_geman_mcclure(const Task& task, const Options& options) {
  GncOptions gnc = options.gnc;
  gnc.loss = GncLoss::kGemanMcClure;
  return solve_gnc(task.problem, gnc);
}

RobustResult solve_pose_by_pose(const Task& task, const Options& options) {
  if (task.graph.poses2.empty() && task.graph.poses3.empty()) {
    throw Error("the online selection needs the pose graph of the problem");
  }
  return solve_online(task.graph, task.problem.initial, {}, options.online);
}

RobustResult solve_filtered(const Task& task, const Options& options, const RobustSolver& solver) {
  return solve_consistent(task.problem, options.consistency, options.common.mixture, solver);
}

std::vector<RobustMethod> make_table() {
  return {
      {"odometry", "", "no closure is accepted", solve_dead_reckoning},
      {"oracle", "", "Levenberg-Marquardt with the true closures only", solve_oracle},
      {"lm", "", "Levenberg-Marquardt with all closures",
       [](const Task& t, const Options& o) { return solve_lm(t.problem, o.common); }},
      {"gnc", "", "graduated non-convexity, truncated least squares",
       [](const Task& t, const Options& o) { return solve_gnc(t.problem, o.gnc); }},
      {"gnc-gm", "", "graduated non-convexity, Geman-McClure", solve_geman_mcclure},
      {"dcs", "", "dynamic covariance scaling",
       [](const Task& t, const Options& o) { return solve_dcs(t.problem, o.dcs); }},
      {"switchable", "", "switchable constraints",
       [](const Task& t, const Options& o) { return solve_switchable(t.problem, o.switchable); }},
      {"max-mixture", "", "max-mixtures",
       [](const Task& t, const Options& o) { return solve_max_mixture(t.problem, o.common); }},
      {"sum-mixture", "", "sum-mixtures",
       [](const Task& t, const Options& o) { return solve_soft_mixture(t.problem, o.common); }},
      {"alternating", "", "the paper's alternation on eq. 16",
       [](const Task& t, const Options& o) { return solve_alternating(t.problem, o.alternation); }},
      {"selection", "escape", "closures are admitted by their predicted innovations",
       [](const Task& t, const Options& o) {
         return select_closures(t.problem, o.portfolio.selection);
       }},
      {"online", "", "pose by pose, closures selected as they arrive", solve_pose_by_pose},
      {"portfolio", "", "several of these and of starts, the lowest joint objective",
       [](const Task& t, const Options& o) { return solve_portfolio(t.problem, o.portfolio); }},
      {"consistency", "", "pairwise consistency, then lm",
       [](const Task& t, const Options& o) {
         return solve_filtered(t, o, [&](const auto& p) { return solve_lm(p, o.common); });
       }},
      {"consistency-gnc", "", "pairwise consistency, then gnc",
       [](const Task& t, const Options& o) {
         return solve_filtered(t, o, [&](const auto& p) { return solve_gnc(p, o.gnc); });
       }},
      {"consistency-selection", "consistency-escape", "pairwise consistency, then selection",
       [](const Task& t, const Options& o) {
         return solve_filtered(
             t, o, [&](const auto& p) { return select_closures(p, o.portfolio.selection); });
       }}};
}

}  // namespace

void MethodOptions::set_mixture(const MixtureOptions& mixture) {
  common.mixture = gnc.mixture = dcs.mixture = switchable.mixture = mixture;
  alternation.mixture = portfolio.selection.mixture = mixture;
  online.mixture = online.selection.mixture = mixture;
  online.mixture.flat = true;
}

void MethodOptions::set_threads(int threads) {
  for (SolverOptions* solver : {&common.solver, &gnc.solver, &dcs.solver, &switchable.solver,
                                &alternation.alternating.continuous, &portfolio.selection.solver,
                                &online.selection.solver}) {
    solver->threads = threads;
  }
}

const std::vector<RobustMethod>& robust_methods() {
  static const std::vector<RobustMethod> kTable = make_table();
  return kTable;
}

const RobustMethod& robust_method(const std::string& name) {
  std::string known;
  for (const RobustMethod& method : robust_methods()) {
    if (name == method.name || (!name.empty() && name == method.old_name)) return method;
    known += (known.empty() ? "" : ", ") + method.name;
  }
  throw Error("there is no method '" + name + "'; known are: " + known);
}

}  // namespace hybrid
