// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <string>
#include <vector>

#include "libhybrid/factors/factor.h"

namespace hybrid::testing {

/// Cost, r and J of a factor, as solvers see them.
struct Linearization {
  double cost = 0.0;
  Eigen::VectorXd r;
  Eigen::MatrixXd J;
};

inline Linearization linearization(const ContinuousFactor& factor, const double* const* x) {
  Linearization l;
  l.r.setZero(factor.rows());
  l.J.setZero(factor.rows(), factor.cols());
  l.cost = factor.linearize(x, l.r.data(), l.J.data());
  return l;
}
inline Linearization linearization(const ContinuousFactor& factor, const Values& values) {
  return linearization(factor, gather(factor.keys(), factor.types(), values).data());
}

/// Central difference of `function` of the storage pointers of a factor, one column per entry of
/// the tangents, Richardson-extrapolated once.
template <class Function>
Eigen::MatrixXd numeric_derivative(const ContinuousFactor& factor, const Values& values,
                                   Function&& function, double step = 1e-4) {
  std::vector<const double*> x = gather(factor.keys(), factor.types(), values);
  std::vector<Eigen::VectorXd> columns;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const VariableType type = factor.types()[i];
    const double* original = x[i];
    for (int d = 0; d < type.dim; ++d) {
      const auto at = [&](double h) -> Eigen::VectorXd {
        std::vector<double> moved(type.size);
        retract(type, original, Eigen::VectorXd(h * Eigen::VectorXd::Unit(type.dim, d)).data(),
                moved.data());
        x[i] = moved.data();
        const Eigen::VectorXd f = function(x.data());
        x[i] = original;
        return f;
      };
      const Eigen::VectorXd coarse = (at(step) - at(-step)) / (2.0 * step);
      const Eigen::VectorXd fine = (at(0.5 * step) - at(-0.5 * step)) / step;
      columns.push_back((4.0 * fine - coarse) / 3.0);
    }
  }
  Eigen::MatrixXd result(columns.empty() ? 0 : columns[0].size(), columns.size());
  for (std::size_t c = 0; c < columns.size(); ++c) result.col(c) = columns[c];
  return result;
}

/// Compares `linearize` with numeric differentiation: the Jacobian with that of the whitened
/// residual (factors without a robust loss), the gradient J'r with that of the cost, and the costs
/// of both evaluation paths.
inline void expect_jacobians(const ContinuousFactor& factor, const Values& values,
                             double tolerance = 1e-7, bool robust = false) {
  const std::string what = factor.name();
  const Linearization l = linearization(factor, values);
  ASSERT_TRUE(l.r.allFinite() && l.J.allFinite()) << what;
  EXPECT_NEAR(factor.cost(values), l.cost, 1e-12 * std::max(1.0, l.cost)) << what;
  if (!robust) {
    const Eigen::MatrixXd J = numeric_derivative(
        factor, values, [&](const double* const* x) { return linearization(factor, x).r; });
    EXPECT_LT((l.J - J).cwiseAbs().maxCoeff(), tolerance * std::max(1.0, J.cwiseAbs().maxCoeff()))
        << what << " Jacobian\n"
        << l.J << "\nnumeric\n"
        << J;
    EXPECT_NEAR(l.cost, 0.5 * l.r.squaredNorm(), 1e-12 * std::max(1.0, l.cost)) << what;
  }
  const Eigen::VectorXd gradient = l.J.transpose() * l.r;
  const Eigen::VectorXd numeric = numeric_derivative(factor, values, [&](const double* const* x) {
                                    return Eigen::VectorXd::Constant(1, factor.cost(x));
                                  }).transpose();
  EXPECT_LT((gradient - numeric).cwiseAbs().maxCoeff(),
            10.0 * tolerance * std::max(1.0, l.cost + numeric.cwiseAbs().maxCoeff()))
      << what << " gradient\n"
      << gradient.transpose() << "\nnumeric\n"
      << numeric.transpose();
}

/// The same for a factor with a robust loss: its residual is scaled by the root of the weight, so
/// only the gradient of the cost can be compared.
inline void expect_robust_gradient(const ContinuousFactor& factor, const Values& values,
                                   double tolerance = 1e-7) {
  expect_jacobians(factor, values, tolerance, true);
}

}  // namespace hybrid::testing
