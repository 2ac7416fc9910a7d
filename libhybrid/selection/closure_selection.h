// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/problem.h"
#include "libhybrid/selection/selection_options.h"

namespace HYBRID_API hybrid {

/// Loop closure selection in batch. Starting from the trusted factors alone, closures are admitted
/// by their predicted innovations, those of largest evidence first, then all others again under the
/// covariances of the new map. A macro-step admits a batch, solves, and drops closures that the
/// solution contradicts; it is kept only if the joint objective of eq. 6 falls, so that Proposition
/// 1 holds for the sequence in `RobustResult::objectives`; else a smaller batch is tried, as where
/// a batch would fill the system so much that its factorisation were many times as expensive. In
/// that sequence outliers have the constant density of eq. 17 at a zero residual, since the small
/// gradients of many false closures would together hold an incomplete map where it is. In the end
/// what was refused is asked again, of the map that has come about.
/// `RobustResult::objective` is that of `mixture`. The inlier probabilities are marginalised over
/// the poses, with the share of inliers found as prior. Throws Error if the trusted factors leave
/// poses undetermined.
RobustResult select_closures(const RobustProblem& problem,
                             const ClosureSelectionOptions& options = {});

}  // namespace hybrid
