// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace hybrid {

inline constexpr int kMostComponents = 6;
using Components = Eigen::Matrix<double, kMostComponents, 1>;

/// The square of a residual of zero mean whose variance is `fixed` plus the sum over unknown
/// variances of their share in it.
struct VarianceRow {
  Components shares = Components::Zero();
  double fixed = 0;
  double square = 0;
  double weight = 1;
  int part = 0;  ///< of the log, for the jackknife
};

/// The variances of greatest likelihood, none negative, by Fisher scoring from `start`. A square
/// counts as nine variances at most, so that outliers have a bounded influence. Components that no
/// row has stay as they are. Rows of part `without` are left out.
Components fit_variances(const std::vector<VarianceRow>& rows, const Components& start,
                         int without = -1);

/// The log-likelihood of these variances, up to a constant, with squares bounded as above.
double log_likelihood(const std::vector<VarianceRow>& rows, const Components& variances);

}  // namespace hybrid
