// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/closures/problem.h"
#include "libhybrid/solvers/options.h"

namespace HYBRID_API hybrid {

struct ClosureSelectionOptions {
  MixtureOptions mixture;  ///< the model of the joint objective
  /// A closure is admitted once the logarithm of its evidence (see EvidenceModel) exceeds that of
  /// the number of closures not admitted by this much: false admissions are then rare in the whole
  /// graph, not only by closure.
  double margin = 1.5;
  /// An admitted closure leaves when its evidence falls short by more than this.
  double hysteresis = 2.0;
  double degrees_of_freedom = 4.0;  ///< of the Student t, see EvidenceModel
  double gate = 4.0;                ///< see EvidenceModel
  /// Where no closure passes alone, let the best two that agree with each other.
  bool pairs = true;
  /// Start with the closures that agree with the initial values, instead of none.
  bool trust_start = false;
  /// Below this redundancy a closure is flagged: no other measurement would reveal a false one.
  double min_redundancy = 0.09;
  /// Refuse closures so flagged, unless the evidence of the odometry alone carries them.
  bool refuse_uncheckable = false;
  int max_rounds = 500;  ///< macro-steps tried
  SolverOptions solver;  ///< of the last solve; those between are rougher
};

/// Robust pose-graph optimisation by re-admission: starting from the trusted factors, closures are
/// admitted by their predicted innovations, those that fit best and are predicted best first, then
/// all others again under the covariances that remain. A macro-step admits a batch, solves, and
/// drops members that the solution contradicts; it is kept only if the joint objective of eq. 6
/// falls, so that Proposition 1 holds for the sequence in `RobustResult::objectives`; else a
/// smaller batch is tried. In that sequence outliers have the constant density of eq. 17 at a zero
/// residual: false closures pull at a map that is not yet complete, each a little, together enough
/// to hold it where it is. `RobustResult::objective` is that of `mixture`.
/// The inlier probabilities are marginalised over the poses, at the share of inliers found.
/// Throws Error where the trusted factors leave poses undetermined.
RobustResult select_closures(const RobustProblem& problem,
                             const ClosureSelectionOptions& options = {});

}  // namespace hybrid
