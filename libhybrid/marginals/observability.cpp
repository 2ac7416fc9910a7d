// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/observability.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "libhybrid/solvers/problem.h"

namespace hybrid {
namespace {

/// Information added to every entry, relative to its own: large beside rounding.
constexpr double kRegularization = 1e-10;
/// An entry whose variance is this share of what the regularisation alone leaves is free.
constexpr double kFreeShare = 1e-3;

}  // namespace

bool ObservedVector::all() const {
  return std::all_of(observable.begin(), observable.end(), [](bool o) { return o; });
}

std::string ObservedVector::text(const std::vector<std::string>& names) const {
  std::string text;
  for (std::size_t i = 0; i < observable.size(); ++i) {
    text += (i == 0 ? "" : ", ") + (i < names.size() ? names[i] : std::to_string(i));
    if (!observable[i]) {
      text += ": unobservable";
      continue;
    }
    char number[64];
    std::snprintf(number, sizeof(number), " = %.6g +- %.2g", values[i], sigmas[i]);
    text += number;
  }
  return text;
}

ObservedVector observe_vector(const HybridGraph& graph, const Estimate& estimate, Key key) {
  Problem problem(graph, estimate.values, estimate.assignment);
  const int block = problem.block(key);
  if (problem.type(block).kind != VariableKind::kVector) {
    throw Error("variable " + to_string(key) + " is " + to_string(problem.type(block)) +
                ", not a vector");
  }
  problem.linearize(problem.load(estimate.values));
  problem.assemble();
  const int dim = problem.type(block).dim;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ObservedVector result;
  result.values = Eigen::VectorXd::Constant(dim, nan);
  result.sigmas = result.values;
  result.observable.assign(dim, false);
  const NormalEquations& system = problem.system();
  const std::vector<int> untouched = system.untouched();
  const bool moved = std::find(untouched.begin(), untouched.end(), block) == untouched.end();
  if (!moved || problem.factorize(kRegularization) >= 0) return result;
  for (int i = 0; i < dim; ++i) {
    std::vector<double> column(system.scalars(), 0.0);
    const int scalar = system.start(block) + i;
    column[scalar] = 1.0;
    system.solve(column.data());
    const double variance = column[scalar];
    const double share = variance * system.diagonal()[scalar] * kRegularization;
    result.observable[i] = variance > 0.0 && share < kFreeShare;
    if (!result.observable[i]) continue;
    result.values[i] = estimate.values.data(key)[i];
    result.sigmas[i] = std::sqrt(variance);
  }
  return result;
}

}  // namespace hybrid
