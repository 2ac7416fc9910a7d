// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/marginals/detail/posterior_model.h"

namespace hybrid {

/// The posterior of a model by the sum over all joint values of its selectors.
AssignmentPosterior enumerate_posterior(PosteriorModel& model);

/// The same by block Gibbs sampling, from the values of the estimate.
AssignmentPosterior sample_posterior(PosteriorModel& model, const PosteriorOptions& options);

}  // namespace hybrid
