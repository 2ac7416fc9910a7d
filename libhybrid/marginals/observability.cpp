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

/// Information added to every entry, relative to its own: little, and much less. A variance that
/// the second leaves larger has no bound but what was added.
constexpr double kLittle = 1e-8, kLess = 1e-10;
constexpr double kGrowth = 1.05;

/// Variances of the scalars of a block with some information added; empty where that fails.
std::vector<double> variances(Problem& problem, int block, double added) {
  std::vector<double> result;
  if (problem.factorize(added) >= 0) return result;
  const NormalEquations& system = problem.system();
  for (int i = 0; i < system.dim(block); ++i) {
    std::vector<double> column(system.scalars(), 0.0);
    column[system.start(block) + i] = 1.0;
    system.solve(column.data());
    result.push_back(column[system.start(block) + i]);
  }
  return result;
}

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
  const std::vector<int> untouched = problem.system().untouched();
  if (std::find(untouched.begin(), untouched.end(), block) != untouched.end()) return result;
  const std::vector<double> upper = variances(problem, block, kLittle);
  const std::vector<double> variance = variances(problem, block, kLess);
  if (upper.empty() || variance.empty()) return result;
  for (int i = 0; i < dim; ++i) {
    result.observable[i] = variance[i] > 0.0 && variance[i] < kGrowth * upper[i];
    if (!result.observable[i]) continue;
    result.values[i] = estimate.values.data(key)[i];
    result.sigmas[i] = std::sqrt(variance[i]);
  }
  return result;
}

}  // namespace hybrid
