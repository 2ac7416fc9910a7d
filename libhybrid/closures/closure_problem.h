// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "libhybrid/closures/kernel.h"
#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/closures/problem.h"
#include "libhybrid/solvers/options.h"
#include "libhybrid/solvers/problem.h"

namespace HYBRID_API hybrid {

/// How a closure enters the linear systems of a method that weights closures.
enum class ClosureRole {
  kCoupled,
  kWeak,   ///< in cost, gradient and diagonal blocks only: it costs no fill-in
  kAbsent  ///< not at all
};

/// Chooses the roles of all closures at the given values.
using RoleRule = std::function<std::vector<ClosureRole>(const Values&)>;

/// A robust problem whose closures are replaced by weighted ones, compiled once: a change of
/// weights needs no new analysis of the sparsity, which only a change of roles can cause.
class ClosureProblem {
 public:
  /// `closures` replace those of the problem, in their order; `extra` are further factors. `start`
  /// holds all variables. `roles` has one role per closure.
  ClosureProblem(const RobustProblem& problem, const std::vector<ContinuousFactorPtr>& closures,
                 const std::vector<ContinuousFactorPtr>& extra, Values start,
                 const std::vector<ClosureRole>& roles, int threads);

  void set_roles(const std::vector<ClosureRole>& roles);
  const std::vector<ClosureRole>& roles() const { return roles_; }
  /// Levenberg-Marquardt from the current values; adds to iterations().
  SolverReport solve(const SolverOptions& options);
  /// Solves in rounds of a few iterations, with roles updated by `rule` after each, until none
  /// changes. Sets values, iterations, converged and message of a result.
  void solve_in_rounds(const SolverOptions& options, const RoleRule& rule, RobustResult& result);
  const Values& values() const { return values_; }
  void set_values(const Values& values) { values_ = values; }
  int iterations() const { return iterations_; }
  /// Sets converged and message of a result from the report of its last solve; if the last
  /// factorisation found the system singular, it did not converge.
  void report(const SolverReport& last, RobustResult& result) const;
  /// How often the sparsity was analysed.
  int analyses() const { return problem_->analyses(); }

 private:
  Assignment assignment() const;

  HybridGraph graph_;
  Values values_;
  std::vector<ClosureRole> roles_;
  std::unique_ptr<Problem> problem_;
  int iterations_ = 0;
  std::string singular_;  // message of the last solve that factorised, if singular
};

/// Options that the baselines share.
struct ComparisonOptions {
  MixtureOptions mixture;  ///< the model under which objective and probabilities are reported
  SolverOptions solver;
  /// Closures of a smaller weight have no off-diagonal blocks in the Hessian.
  double negligible_weight = 1e-6;
};

/// Squared whitened residuals of the closures, in their order.
std::vector<double> chi_squares(const RobustProblem& problem, const Values& values);

/// Minimises trusted factors plus closures under kernels, one per closure. Closures of negligible
/// weight are weak; roles are updated until none changes. Closures whose final weight is at least
/// `least_weight` are accepted.
RobustResult solve_kernels(const RobustProblem& problem, const std::vector<Kernel>& kernels,
                           double least_weight, const ComparisonOptions& options);

/// Fills decisions, objective and cost of a result that has values.
void finish(const RobustProblem& problem, const std::vector<bool>& accepted,
            const MixtureOptions& mixture, RobustResult& result);

}  // namespace hybrid
