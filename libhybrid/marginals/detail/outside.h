// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/marginals/detail/site.h"

namespace hybrid {

/// The information of the rest of a graph on some variables, that is their joint Gaussian without
/// the present factors of the sites, as a linear prior; it may leave directions undetermined. Exact
/// if the rest is linear. Null if the rest has no information. Throws Error if the rounding errors
/// of the covariance are too large.
ContinuousFactorPtr outside_prior(const JointGaussian& gaussian, const std::vector<Site>& sites);

}  // namespace hybrid
