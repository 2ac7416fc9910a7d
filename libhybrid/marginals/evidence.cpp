// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/evidence.h"

#include <cmath>
#include <limits>

#include "libhybrid/marginals/log_determinant.h"

namespace hybrid {
namespace {

constexpr double kLog2Pi = 1.8378770664093454836;

}  // namespace

Evidence log_evidence(const HybridGraph& graph, const Estimate& estimate, int threads) {
  Problem problem(graph, estimate.values, estimate.assignment, threads, WeakComponents::kCoupled);
  const double objective = problem.linearize(problem.load(estimate.values)) + problem.constant();
  if (std::isinf(objective)) return {-std::numeric_limits<double>::infinity(), {}};
  const LogDeterminant hessian = log_determinant(problem);
  if (!hessian.under_constrained.empty()) return {std::nullopt, hessian.under_constrained};
  return {-objective + 0.5 * (problem.system().scalars() * kLog2Pi - hessian.value), {}};
}

}  // namespace hybrid
