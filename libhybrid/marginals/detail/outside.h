// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/marginals/detail/site.h"

namespace hybrid {

/// What the rest of a graph says of some variables, once the present factors of the sites are taken
/// out of their joint Gaussian: a linear prior, which may leave directions undetermined. Exact
/// where the rest is linear. Null where the rest says nothing. Throws Error where the covariance
/// has too large rounding errors to tell.
ContinuousFactorPtr outside_prior(const JointGaussian& gaussian, const std::vector<Site>& sites);

}  // namespace hybrid
