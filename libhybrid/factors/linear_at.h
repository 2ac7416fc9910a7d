// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>

#include "libhybrid/core/values.h"
#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// A factor at some values: its whitened residual r, and the Jacobian J of that, the columns of its
/// variables side by side.
struct ResidualAndJacobian {
  Eigen::VectorXd r;
  Eigen::MatrixXd J;
};

inline ResidualAndJacobian linear_at(const ContinuousFactor& factor, const Values& values) {
  const auto x = gather(factor.keys(), factor.types(), values);
  ResidualAndJacobian linear{Eigen::VectorXd(factor.rows()),
                             Eigen::MatrixXd(factor.rows(), factor.cols())};
  factor.linearize(x.data(), linear.r.data(), linear.J.data());
  return linear;
}

}  // namespace hybrid
