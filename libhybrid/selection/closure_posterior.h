// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/mixture_graph.h"

namespace HYBRID_API hybrid {

/// Replaces the inlier probabilities of a result, unless the poses are integrated out already, by
/// p(inlier | Z) of every closure under the mixture of eq. 17, given the decisions on all others;
/// eq. 14 takes the poses as known instead. Other closures that are rejected have no influence on
/// the poses, whatever the outlier model. The poses are optimised for the decisions. If the trusted
/// and accepted factors leave some undetermined, nothing changes.
void integrate_poses(const RobustProblem& problem, const MixtureOptions& options,
                     RobustResult& result);

}  // namespace hybrid
