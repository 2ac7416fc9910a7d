// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <functional>
#include <vector>

#include "libhybrid/factors/factor.h"
#include "libhybrid/geometry/eigen.h"

namespace hybrid {

/// Kullback-Leibler divergence [nat] of the density of a graph, a Gaussian about the estimate that
/// minimises its cost, from what it is without some of its factors; +infinity where something is
/// determined by these alone. With C = J Sigma J' for their whitened residuals r and Jacobians J it
/// is (r' C (I - C)^-1 r - tr C - log det(I - C)) / 2. Of fewer variables, once others have been
/// marginalised, it is no more.
double divergence_without(
    const std::vector<const ContinuousFactor*>& factors, const Values& values,
    const std::function<Eigen::MatrixXd(const std::vector<Key>&)>& joint_covariance);

}  // namespace hybrid
