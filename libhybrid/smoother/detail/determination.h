// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/smoother/journaled_values.h"
#include "libhybrid/smoother/linear_models.h"

namespace hybrid {

/// Whether the factors of a graph determine all of its variables, of which those at `slots` have
/// pivots that are lost in rounding. At the last commit all were determined. So where nothing was
/// lost since then, or nothing that others do not say, all are if the new variables are, given the
/// others. Else the whole graph is looked at, which costs what a batch factorisation does.
bool are_determined(const std::vector<int>& slots, const LinearModels& models,
                    const JournaledValues& estimate, const HybridGraph& graph,
                    const Assignment& assignment);

}  // namespace hybrid
