// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/evidence.h"

#include <cmath>
#include <limits>

#include "libhybrid/marginals/detail/exchange.h"
#include "libhybrid/marginals/log_determinant.h"

namespace hybrid {
namespace {

constexpr double kLog2Pi = 1.8378770664093454836;

/// -log of the density of a factor at the values, normaliser included; 0 for null.
double whole_cost(const ContinuousFactor* factor, const Values& values) {
  return factor == nullptr ? 0.0 : factor->cost(values) + factor->log_normalizer();
}

}  // namespace

Evidence log_evidence(const HybridGraph& graph, const Estimate& estimate, int threads) {
  Problem problem(graph, estimate.values, estimate.assignment, threads, WeakComponents::kCoupled);
  const double objective = problem.linearize(problem.load(estimate.values)) + problem.constant();
  if (std::isinf(objective)) return {-std::numeric_limits<double>::infinity(), {}};
  const LogDeterminant hessian = log_determinant(problem);
  if (!hessian.under_constrained.empty()) return {std::nullopt, hessian.under_constrained};
  return {-objective + 0.5 * (problem.system().scalars() * kLog2Pi - hessian.value), {}};
}

std::optional<double> log_evidence_change(const std::vector<Key>& keys,
                                          const Eigen::MatrixXd& covariance, const Values& values,
                                          const ContinuousFactor* from,
                                          const ContinuousFactor* to) {
  const JointGaussian gaussian(keys, covariance, values);
  const Exchange exchange(gaussian, {{{from, to}, 0}});
  const std::optional<double> change = exchange.log_change({1});
  if (!change) return change;
  return *change + whole_cost(from, values) - whole_cost(to, values);
}

}  // namespace hybrid
