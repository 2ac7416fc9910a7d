// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libhybrid/factors/factor.h"

namespace hybrid {

/// A Gaussian on several variables, linear in their tangents at a fixed point x0: residual
/// R (x boxminus x0) + r. What marginalisation leaves behind.
class LinearPrior : public ContinuousFactor {
 public:
  /// `points` holds x0; R has one column per tangent dimension of `keys`, in their order.
  LinearPrior(const std::vector<Key>& keys, const Values& points, Eigen::MatrixXd R,
              Eigen::VectorXd r);

  /// From the information form: Lambda (symmetric, positive semidefinite) and gradient eta at x0,
  /// so that the cost is x' Lambda x / 2 + eta' x up to a constant.
  static ContinuousFactorPtr from_information(const std::vector<Key>& keys, const Values& points,
                                              const Eigen::MatrixXd& information,
                                              const Eigen::VectorXd& gradient);

  double cost(const double* const* x) const override;
  double linearize(const double* const* x, double* r, double* J) const override;
  double log_normalizer() const override { return 0.0; }
  std::string name() const override { return "linear prior"; }
  using ContinuousFactor::cost;

 private:
  Eigen::VectorXd tangent(const double* const* x) const;

  std::vector<double> points_;
  Eigen::MatrixXd R_;
  Eigen::VectorXd r_;
};

}  // namespace hybrid
