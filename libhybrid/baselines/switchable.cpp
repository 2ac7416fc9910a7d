// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/baselines/switchable.h"

#include <cmath>
#include <utility>

#include "libhybrid/core/elapsed.h"
#include "libhybrid/factors/prior.h"

namespace hybrid {
namespace {

using Vector1 = Eigen::Matrix<double, 1, 1>;

std::vector<Key> with_switch(std::vector<Key> keys, Key switch_key) {
  keys.push_back(switch_key);
  return keys;
}

std::vector<VariableType> with_scalar(std::vector<VariableType> types) {
  types.push_back(Variable<Vector1>::type());
  return types;
}

std::vector<double> switches(const Values& values, std::size_t count) {
  std::vector<double> result;
  for (std::size_t k = 0; k < count; ++k) result.push_back(*values.data(real_switch(k)));
  return result;
}

std::vector<ClosureRole> roles_of(const std::vector<double>& switches, double negligible) {
  std::vector<ClosureRole> roles;
  for (double s : switches) {
    roles.push_back(s * s < negligible ? ClosureRole::kWeak : ClosureRole::kCoupled);
  }
  return roles;
}

}  // namespace

SwitchedFactor::SwitchedFactor(ContinuousFactorPtr factor, Key switch_key)
    : ContinuousFactor(with_switch(factor->keys(), switch_key), with_scalar(factor->types()),
                       factor->rows()),
      factor_(std::move(factor)) {}

double SwitchedFactor::cost(const double* const* x) const {
  const double s = *x[keys().size() - 1];
  return s * s * factor_->cost(x);
}

double SwitchedFactor::linearize(const double* const* x, double* r, double* J) const {
  const double s = *x[keys().size() - 1];
  const double cost = factor_->linearize(x, r, J);
  Eigen::Map<Eigen::VectorXd> residual(r, rows());
  Eigen::Map<Eigen::MatrixXd> jacobian(J, rows(), cols());
  jacobian.leftCols(cols() - 1) *= s;
  jacobian.col(cols() - 1) = residual;
  residual *= s;
  return s * s * cost;
}

double best_switch(double chi_square, double phi) {
  return phi / (phi + chi_square);
}

RobustResult solve_switchable(const RobustProblem& problem, const SwitchableOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  if (!(options.phi > 0.0)) {
    throw Error("phi of switchable constraints must be positive, got " +
                std::to_string(options.phi));
  }
  const std::size_t count = problem.closures.size();
  const Noise prior = Noise::isotropic(1, 1.0 / std::sqrt(options.phi));
  std::vector<ContinuousFactorPtr> switched, priors;
  Values values = problem.initial;
  for (std::size_t k = 0; k < count; ++k) {
    const Key key = real_switch(k);
    switched.push_back(std::make_shared<SwitchedFactor>(problem.closures[k], key));
    priors.push_back(std::make_shared<Prior<Vector1>>(key, Vector1::Ones(), prior));
    values.insert(key, Vector1(Vector1::Ones()));
  }
  ClosureProblem weighted(problem, switched, priors, std::move(values),
                          std::vector<ClosureRole>(count, ClosureRole::kCoupled),
                          options.solver.threads);
  RobustResult result;
  result.method = "switchable";
  const auto rule = [&](const Values& at) {
    return roles_of(switches(at, count), options.negligible_weight);
  };
  weighted.solve_in_rounds(options.solver, rule, result);
  std::vector<bool> accepted;
  for (double s : switches(result.values, count)) accepted.push_back(s >= 0.5);
  for (std::size_t k = 0; k < count; ++k) result.values.erase(real_switch(k));
  finish(problem, accepted, options.mixture, result);
  result.seconds = seconds_since(start);
  return result;
}

}  // namespace hybrid
