// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// How a zero-mean Gaussian of covariance S judges a residual.
struct GaussianScore {
  double chi_square = 0.0;  ///< r' S^-1 r
  double cost = 0.0;        ///< -log N(r; 0, S), normaliser included
};

/// Both are +infinity where S is not positive definite.
GaussianScore gaussian_score(const Eigen::VectorXd& residual, const Eigen::MatrixXd& covariance);

}  // namespace hybrid
