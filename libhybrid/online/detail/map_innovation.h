// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/selection/innovation.h"
#include "libhybrid/smoother/incremental.h"

namespace hybrid {

/// The residual of a factor that is not in a map, and its covariance by the map.
Innovation innovation_of(const ContinuousFactor& factor, const IncrementalSmoother& smoother);

/// A P B' of two factors with the Jacobians A and B, and P the covariance of the map.
Eigen::MatrixXd cross_covariance(const ContinuousFactor& a, const ContinuousFactor& b,
                                 const IncrementalSmoother& smoother);

}  // namespace hybrid
