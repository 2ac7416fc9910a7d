// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <map>
#include <vector>

#include "libhybrid/smoother/incremental.h"
#include "libhybrid/smoother/window_tables.h"

namespace hybrid {

/// Discrete variables that leave at their values.
struct FixedVariables {
  Assignment values;
  std::map<Key, Table> posterior;  ///< -log p of each, zero at its value
  double divergence = 0.0;
};

/// Fixes discrete variables at their values. The remaining joint density is then the conditional
/// one, whose Kullback-Leibler divergence from the joint density is -log p of the values.
FixedVariables fix(const std::vector<Key>& discrete, const IncrementalSmoother& smoother);

/// Replaces the tables that tie fixed variables to others by what they say of those; what breaks
/// leave out counts in the objective as it is.
void condition_on(const FixedVariables& fixed, const std::vector<Handle>& breaks,
                  const IncrementalSmoother& smoother, const WindowTables& tables, Delta& change);

}  // namespace hybrid
