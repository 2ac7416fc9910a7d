// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/closures/mixture_graph.h"

#include <cmath>
#include <memory>
#include <sstream>
#include <string>

#include "libhybrid/core/error.h"
#include "libhybrid/factors/inflated.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/pose_graph/pose_graph.h"

namespace hybrid {
namespace {

/// -log of the two weighted components of a closure.
struct Costs {
  double inlier = 0.0;
  double outlier = 0.0;
};

/// Throws SettingsError, which names the option, where these are no model. All robust methods do.
void check(const MixtureOptions& options) {
  const auto need = [](bool holds, const char* name, double value, const char* what) {
    if (holds) return;
    std::ostringstream text;
    text << name << " of the model of true and false closures is " << value << "; it must be "
         << what;
    throw SettingsError(text.str());
  };
  const auto is_weight = [](double weight) { return weight > 0.0 && std::isfinite(weight); };
  need(options.outlier_variance >= 1.0 && options.outlier_variance <= 1e12, "outlier_variance",
       options.outlier_variance, "from 1 to 1e12");
  need(is_weight(options.inlier_weight), "inlier_weight", options.inlier_weight,
       "a positive number");
  need(is_weight(options.outlier_weight), "outlier_weight", options.outlier_weight,
       "a positive number");
  const double null = options.null_hypothesis.value_or(0.0);
  need(std::isfinite(null), "null_hypothesis", null, "a finite number");
}

void check_decisions(const RobustProblem& problem, const std::vector<bool>& accepted) {
  if (accepted.size() == problem.closures.size()) return;
  throw Error("decisions on " + std::to_string(accepted.size()) + " closures for " +
              std::to_string(problem.closures.size()));
}

/// -log density of the constant outlier model; empty for the wide Gaussian.
std::optional<double> null_density(const ContinuousFactor& closure, const MixtureOptions& options) {
  if (options.null_hypothesis || !options.flat) return options.null_hypothesis;
  return closure.log_normalizer() + 0.5 * closure.rows() * std::log(options.outlier_variance);
}

Costs component_costs(const ContinuousFactor& closure, double cost, const MixtureOptions& options) {
  Costs costs;
  costs.inlier = cost + closure.log_normalizer() - std::log(options.inlier_weight);
  const std::optional<double> null = null_density(closure, options);
  costs.outlier = null ? *null
                       : cost / options.outlier_variance + closure.log_normalizer() +
                             0.5 * closure.rows() * std::log(options.outlier_variance);
  costs.outlier -= std::log(options.outlier_weight);
  return costs;
}

}  // namespace

HybridFactorPtr closure_mixture(std::size_t closure, const ContinuousFactorPtr& factor,
                                const MixtureOptions& options) {
  check(options);
  const std::optional<double> null = null_density(*factor, options);
  if (!null) {
    return make_outlier_mixture(closure_switch(closure), factor,
                                std::make_shared<Inflated>(factor, options.outlier_variance),
                                options.inlier_weight, options.outlier_weight);
  }
  std::vector<MixtureComponent> components;
  components.push_back({factor, -std::log(options.inlier_weight), false});
  components.push_back({nullptr, *null - std::log(options.outlier_weight), true});
  return std::make_shared<Mixture>(std::vector<DiscreteKey>{closure_switch(closure)},
                                   std::move(components));
}

OutlierLine outlier_line(const ContinuousFactor& closure, const MixtureOptions& options) {
  check(options);
  const double prior = 2.0 * std::log(options.inlier_weight / options.outlier_weight);
  if (options.null_hypothesis) {
    return {INFINITY, 2.0 * (*options.null_hypothesis - closure.log_normalizer()) + prior};
  }
  return {options.flat ? INFINITY : options.outlier_variance,
          closure.rows() * std::log(options.outlier_variance) + prior};
}

HybridGraph mixture_graph(const RobustProblem& problem, const MixtureOptions& options) {
  check(options);
  HybridGraph graph(problem.trusted);
  for (std::size_t k = 0; k < problem.closures.size(); ++k) {
    graph.add(closure_mixture(k, problem.closures[k], options));
  }
  return graph;
}

std::vector<ContinuousFactorPtr> factors_in_force(const RobustProblem& problem,
                                                  const std::vector<bool>& accepted) {
  check_decisions(problem, accepted);
  std::vector<ContinuousFactorPtr> factors = problem.trusted;
  for (std::size_t k = 0; k < accepted.size(); ++k) {
    if (accepted[k]) factors.push_back(problem.closures[k]);
  }
  return factors;
}

Assignment to_assignment(const std::vector<bool>& accepted) {
  Assignment assignment;
  for (std::size_t k = 0; k < accepted.size(); ++k) {
    assignment.set(closure_switch(k).key, accepted[k] ? 0 : 1);
  }
  return assignment;
}

JointObjective joint_objective(const RobustProblem& problem, const Values& values,
                               const std::vector<bool>& accepted, const MixtureOptions& options) {
  check(options);
  check_decisions(problem, accepted);
  JointObjective joint;
  for (const ContinuousFactorPtr& factor : problem.trusted) {
    const double cost = factor->cost(values);
    joint.cost += cost;
    joint.objective += cost + factor->log_normalizer();
  }
  for (std::size_t k = 0; k < problem.closures.size(); ++k) {
    const ContinuousFactor& closure = *problem.closures[k];
    const double cost = closure.cost(values);
    const Costs costs = component_costs(closure, cost, options);
    if (accepted[k]) joint.cost += cost;
    joint.objective += accepted[k] ? costs.inlier : costs.outlier;
  }
  return joint;
}

std::vector<ClosureDecision> make_decisions(const RobustProblem& problem, const Values& values,
                                            const std::vector<bool>& accepted,
                                            const MixtureOptions& options) {
  check(options);
  check_decisions(problem, accepted);
  std::vector<ClosureDecision> decisions(problem.closures.size());
  for (std::size_t k = 0; k < decisions.size(); ++k) {
    const ContinuousFactor& closure = *problem.closures[k];
    const double cost = closure.cost(values);
    const Costs costs = component_costs(closure, cost, options);
    decisions[k].accept(accepted[k]);
    decisions[k].chi_square = 2.0 * cost;
    decisions[k].inlier_probability = 1.0 / (1.0 + std::exp(costs.inlier - costs.outlier));
  }
  return decisions;
}

RobustProblem to_robust_problem(const PoseGraph& graph, const Values& initial, const Trust& trusted,
                                const GraphFactorOptions& options) {
  RobustProblem problem;
  problem.initial = initial;
  const Trust trust = trusted ? trusted : OdometryEdges(graph);
  const std::size_t relative_poses = graph.poses2.size() + graph.poses3.size();
  std::vector<ContinuousFactorPtr> factors = to_factors(graph, initial, options);
  for (std::size_t f = 0; f < factors.size(); ++f) {
    const std::vector<Key>& keys = factors[f]->keys();
    const bool closure = f < relative_poses && !trust(keys[0], keys[1]);
    (closure ? problem.closures : problem.trusted).push_back(std::move(factors[f]));
  }
  return problem;
}

}  // namespace hybrid
