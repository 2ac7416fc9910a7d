// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libhybrid/hybrid/graph.h"

namespace HYBRID_API hybrid {

/// The entries of a vector variable, as a calibration: value and standard deviation of those that
/// the factors determine. For the others both are NaN. An entry is determined if no undetermined
/// direction of the variable changes it: of a point undetermined along (1, 1) neither entry is,
/// although their difference is.
struct ObservedVector {
  Eigen::VectorXd values, sigmas;
  std::vector<bool> observable;

  bool all() const;
  /// "f = 500.1 +- 0.2, cx: unobservable, ..." with these names of the entries.
  std::string text(const std::vector<std::string>& names) const;
};

/// Which entries of a vector variable the factors determine at the estimate (see ExtendedCholesky).
/// Undetermined directions that do not change the variable (such as the choice of the map's frame)
/// do not matter. An entry that only a vague prior constrains is determined, with a large standard
/// deviation. Costs a factorisation in extended precision. Throws Error for a variable that is no
/// vector or in no factor.
ObservedVector observe_vector(const HybridGraph& graph, const Estimate& estimate, Key key);

}  // namespace hybrid
