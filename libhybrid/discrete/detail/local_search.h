// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/discrete/junction_forest.h"

namespace hybrid {

/// Lowers the cost of one component by block coordinate descent, from `values` (by variable id, all
/// given): the variables of an induced forest are optimised together, exactly, with the others held
/// fixed. A sweep grows forests until every variable was in one. Stops at the first sweep without
/// gain. Impossible entries count as a penalty above all finite differences, so that the search
/// avoids them if it can.
void local_search(const DiscreteGraph& graph, int component, int max_sweeps,
                  std::vector<int>& values);

}  // namespace hybrid
