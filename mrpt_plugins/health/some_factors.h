// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "libhybrid/core/error.h"
#include "libhybrid/factors/factor.h"
#include "libhybrid/marginals/continuous.h"

namespace HYBRID_API hybrid {

/// Calls visit(whitened residual, its Jacobian, covariance of the variables) for factors evenly
/// over a run, at most 200 of them, from a list of pointers. What is not determined, or has no
/// value, is left out.
template <class Factors, class Visit>
void for_some_factors(const Factors& factors, const ContinuousMarginals& marginals,
                      const Values& values, const Visit& visit) {
  constexpr std::size_t kMost = 200;
  const std::size_t every = factors.size() / kMost + 1;
  for (std::size_t i = 0; i < factors.size(); i += every) {
    const ContinuousFactor& factor = *factors[i];
    Eigen::VectorXd r(factor.rows());
    Eigen::MatrixXd J(factor.rows(), factor.cols());
    try {
      const auto x = gather(factor.keys(), factor.types(), values);
      factor.linearize(x.data(), r.data(), J.data());
      visit(r, J, marginals.joint_covariance(factor.keys()));
    } catch (const Error&) {  // says nothing
    }
  }
}

}  // namespace hybrid
