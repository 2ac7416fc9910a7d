// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/closures/problem.h"
#include "libhybrid/solvers/options.h"

namespace HYBRID_API hybrid {

struct ClosureSelectionOptions {
  MixtureOptions mixture;  ///< the model of the joint objective
  /// A closure is admitted once the logarithm of its evidence (see EvidenceModel) exceeds the
  /// logarithm of the number of closures not admitted by this much, so that false admissions are
  /// rare in the whole graph, not only for each closure. It is dropped again when the logarithm of
  /// its evidence is below that of this number by as much.
  double margin = 1.5;
  double degrees_of_freedom = 4.0;  ///< of the Student t, see EvidenceModel
  double gate = 4.0;                ///< see EvidenceModel
  /// Whether pairs of closures that agree with each other may be admitted if none passes alone.
  bool pairs = true;
  /// Whether to start with the closures that agree with the initial values, instead of none.
  bool trust_start = false;
  /// Below this redundancy a closure is flagged: no other measurement would reveal a false one.
  double min_redundancy = 0.09;
  /// Whether to reject the closures that are flagged.
  bool refuse_uncheckable = false;
  int max_rounds = 500;  ///< macro-steps tried
  SolverOptions solver;  ///< of the last solve; those between are rougher
};

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
