// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>

#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// The agreement of a measurement with an estimate that does not include it, by the whitened
/// residual b and its predicted covariance S = I + A P A', with A the whitened Jacobian and P the
/// joint covariance of the variables.
struct Prediction {
  double chi_square = 0.0;       ///< b' S^-1 b
  double log_determinant = 0.0;  ///< log |S|, at least 0
  /// tr(S^-1) / d in (0, 1]: the share of the measurement that would still be checked by the other
  /// factors if it were added. It equals tr(I - A P' A') / d with P' the covariance after that.
  double redundancy = 1.0;
  Eigen::MatrixXd information;  ///< S^-1
};

/// The prediction at x, where x[i] is the storage of variable i of the factor and P (cols x cols)
/// is the joint covariance of their tangents.
Prediction predict_measurement(const ContinuousFactor& factor, const double* const* x,
                               const Eigen::MatrixXd& P);

/// tr(I - A P A') / d of a factor that is part of the estimate of covariance P.
double joined_redundancy(const ContinuousFactor& factor, const double* const* x,
                         const Eigen::MatrixXd& P);

/// b' W b at x for a W of an earlier prediction.
double chi_square_under(const ContinuousFactor& factor, const double* const* x,
                        const Eigen::MatrixXd& W);

}  // namespace hybrid
