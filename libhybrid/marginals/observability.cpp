// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/observability.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

#include "libhybrid/solvers/null_space.h"
#include "libhybrid/solvers/problem.h"

namespace hybrid {
namespace {

/// Half of the digits: an undetermined direction with a smaller component along an entry changes it
/// by rounding only.
constexpr double kAlong = 1e-8;

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
  const ExtendedCholesky factor = problem.extended_factor();
  const Eigen::MatrixXd& free = factor.free_directions(block);
  const Eigen::VectorXd variances = factor.covariance({block}).diagonal();
  const int dim = problem.type(block).dim;
  const double nan = std::numeric_limits<double>::quiet_NaN();
  ObservedVector result;
  result.values = Eigen::VectorXd::Constant(dim, nan);
  result.sigmas = result.values;
  result.observable.assign(dim, false);
  for (int i = 0; i < dim; ++i) {
    result.observable[i] = free.cols() == 0 || free.row(i).norm() < kAlong;
    if (!result.observable[i]) continue;
    result.values[i] = estimate.values.data(key)[i];
    result.sigmas[i] = std::sqrt(variances[i]);
  }
  return result;
}

}  // namespace hybrid
