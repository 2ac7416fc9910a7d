// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/linear/tree/pending_rows.h"

namespace HYBRID_API hybrid {

/// By how much the objective may rise, at most, where a subtree stays as it is or moves as a whole.
struct Bend {
  double whole = 0.0;       ///< whatever is in it
  double per_factor = 0.0;  ///< and for each of its factors
};

/// Solves for the steps, from the top of a Bayes tree down to where they matter: see
/// BayesTree::solve. The system lists the variables that have moved.
void back_substitute(const TreeParts& tree, Charts* charts, double threshold, const Bend& bend);

}  // namespace hybrid
