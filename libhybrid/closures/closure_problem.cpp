// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/closures/closure_problem.h"

#include <utility>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/core/key_letters.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/solvers/levenberg_marquardt.h"

namespace hybrid {
namespace {

constexpr int kRounds = 50;  // of roles
constexpr int kIterationsPerRound = 10;

DiscreteKey role_key(std::size_t closure) {
  return {Key(key_letter::kClosureChoice, closure), 3};
}

std::vector<ClosureRole> roles_of(const RobustProblem& problem, const std::vector<Kernel>& kernels,
                                  const Values& values, double negligible) {
  const std::vector<double> chi_square = chi_squares(problem, values);
  std::vector<ClosureRole> roles;
  for (std::size_t k = 0; k < kernels.size(); ++k) {
    const bool weak = kernels[k].weight(chi_square[k]) < negligible;
    roles.push_back(weak ? ClosureRole::kWeak : ClosureRole::kCoupled);
  }
  return roles;
}

}  // namespace

ClosureProblem::ClosureProblem(const RobustProblem& problem,
                               const std::vector<ContinuousFactorPtr>& closures,
                               const std::vector<ContinuousFactorPtr>& extra, Values start,
                               const std::vector<ClosureRole>& roles, int threads)
    : graph_(problem.trusted), values_(std::move(start)), roles_(roles) {
  for (const ContinuousFactorPtr& factor : extra) graph_.add(factor);
  for (std::size_t k = 0; k < closures.size(); ++k) {
    std::vector<MixtureComponent> components;
    components.push_back({closures[k], 0.0, false});
    components.push_back({closures[k], 0.0, true});
    components.push_back({nullptr, 0.0, true});
    graph_.add(
        std::make_shared<Mixture>(std::vector<DiscreteKey>{role_key(k)}, std::move(components)));
  }
  problem_ = std::make_unique<Problem>(graph_, values_, assignment(), threads);
}

Assignment ClosureProblem::assignment() const {
  Assignment assignment;
  for (std::size_t k = 0; k < roles_.size(); ++k) {
    assignment.set(role_key(k).key, static_cast<int>(roles_[k]));
  }
  return assignment;
}

void ClosureProblem::set_roles(const std::vector<ClosureRole>& roles) {
  if (roles == roles_) return;
  roles_ = roles;
  problem_->set_assignment(assignment());
}

SolverReport ClosureProblem::solve(const SolverOptions& options) {
  Problem::State state = problem_->load(values_);
  SolverReport report = levenberg_marquardt(*problem_, state, options);
  problem_->store(state, values_);
  iterations_ += report.iterations;
  if (report.iterations > 0) {
    singular_ = report.status == SolverStatus::kUnderConstrained ? report.message : "";
  }
  return report;
}

void ClosureProblem::solve_in_rounds(const SolverOptions& options, const RoleRule& rule,
                                     RobustResult& result) {
  result.converged = false;
  SolverOptions few = options;
  few.max_iterations = kIterationsPerRound;
  for (int round = 0; round < kRounds && iterations_ < options.max_iterations; ++round) {
    const SolverReport last = solve(few);
    report(last, result);
    const std::vector<ClosureRole> next = rule(values_);
    if (last.status != SolverStatus::kIterationLimit && next == roles_) break;
    set_roles(next);
  }
  result.values = values_;
  result.iterations = iterations_;
}

void ClosureProblem::report(const SolverReport& last, RobustResult& result) const {
  result.converged = singular_.empty() && last.status == SolverStatus::kConverged;
  result.message = singular_.empty() ? last.message : singular_;
  if (singular_.empty() && last.status == SolverStatus::kIterationLimit) {
    result.message =
        "not converged after " + std::to_string(iterations_) + " iterations, the limit";
  }
}

std::vector<double> chi_squares(const RobustProblem& problem, const Values& values) {
  std::vector<double> result;
  result.reserve(problem.closures.size());
  for (const ContinuousFactorPtr& closure : problem.closures) {
    result.push_back(2.0 * closure->cost(values));
  }
  return result;
}

RobustResult solve_kernels(const RobustProblem& problem, const std::vector<Kernel>& kernels,
                           double least_weight, const ComparisonOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<ContinuousFactorPtr> closures;
  for (std::size_t k = 0; k < kernels.size(); ++k) {
    closures.push_back(std::make_shared<KernelFactor>(problem.closures[k], kernels[k]));
  }
  const auto roles = [&](const Values& values) {
    return roles_of(problem, kernels, values, options.negligible_weight);
  };
  ClosureProblem weighted(problem, closures, {}, problem.initial, roles(problem.initial),
                          options.solver.threads);
  RobustResult result;
  weighted.solve_in_rounds(options.solver, roles, result);
  const std::vector<double> chi_square = chi_squares(problem, result.values);
  std::vector<bool> accepted;
  for (std::size_t k = 0; k < kernels.size(); ++k) {
    accepted.push_back(kernels[k].weight(chi_square[k]) >= least_weight);
  }
  finish(problem, accepted, options.mixture, result);
  result.seconds = seconds_since(start);
  return result;
}

void finish(const RobustProblem& problem, const std::vector<bool>& accepted,
            const MixtureOptions& mixture, RobustResult& result) {
  result.decisions = make_decisions(problem, result.values, accepted, mixture);
  const JointObjective joint = joint_objective(problem, result.values, accepted, mixture);
  result.objective = joint.objective;
  result.cost = joint.cost;
}

}  // namespace hybrid
