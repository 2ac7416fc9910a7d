// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/closures/mixture_graph.h"
#include "libhybrid/solvers/options.h"

namespace HYBRID_API hybrid {

/// Options of select_closures().
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

}  // namespace hybrid
