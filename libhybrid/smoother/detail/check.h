// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/smoother/discrete_half.h"
#include "libhybrid/smoother/journaled_values.h"
#include "libhybrid/smoother/terms.h"

namespace hybrid {

/// Throws Error for anything in a change that would leave a graph inconsistent: terms and the
/// discrete half are those of its factors.
void check(const Delta& delta, const HybridGraph& graph, const JournaledValues& values,
           const Terms& terms, const DiscreteHalf& discrete);

}  // namespace hybrid
