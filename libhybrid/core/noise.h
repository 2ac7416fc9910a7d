// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Zero-mean Gaussian noise of a measurement, held as an upper-triangular square-root information
/// matrix R with R'R = inverse covariance, so that the whitened residual is R e.
class Noise {
 public:
  /// Standard deviations must be positive and finite, matrices symmetric positive definite; else
  /// Error. `dim` is at most 4096, since the matrix is dense.
  static Noise isotropic(int dim, double sigma);
  static Noise diagonal(const Eigen::VectorXd& sigmas);
  static Noise covariance(const Eigen::MatrixXd& covariance);
  static Noise information(const Eigen::MatrixXd& information);
  static Noise unit(int dim) { return isotropic(dim, 1.0); }

  int dim() const { return static_cast<int>(sqrt_information_.rows()); }
  const Eigen::MatrixXd& sqrt_information() const { return sqrt_information_; }
  Eigen::MatrixXd information() const;
  Eigen::MatrixXd covariance() const;

  /// -log of the density at zero: log((2 pi)^(n/2) |Sigma|^(1/2)).
  double log_normalizer() const { return log_normalizer_; }

  /// The same noise with its covariance multiplied by `factor` > 0 (the outlier model of eq. 17).
  Noise inflated(double factor) const;

 private:
  explicit Noise(Eigen::MatrixXd sqrt_information);

  Eigen::MatrixXd sqrt_information_;
  double log_normalizer_ = 0.0;
};

}  // namespace hybrid
