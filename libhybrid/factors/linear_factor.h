// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libhybrid/core/noise.h"
#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// A linear measurement of vectors whose lengths are known at run time: residual sum A_i x_i - b.
class LinearFactor : public ContinuousFactor {
 public:
  struct Term {
    Key key;
    Eigen::MatrixXd A;  ///< (rows of b) x (length of the variable)
  };

  /// Throws Error if sizes do not fit, a number is not finite or there is no term.
  LinearFactor(const std::vector<Term>& terms, const Eigen::VectorXd& b, const Noise& noise);

  double cost(const double* const* x) const override;
  double linearize(const double* const* x, double* r, double* J) const override;
  double log_normalizer() const override { return log_normalizer_; }
  std::string name() const override { return "linear"; }

  using ContinuousFactor::cost;

 private:
  Eigen::VectorXd whitened_residual(const double* const* x) const;

  Eigen::MatrixXd A_;  // matrices of all terms side by side, whitened
  Eigen::VectorXd b_;  // whitened
  double log_normalizer_;
};

}  // namespace hybrid
