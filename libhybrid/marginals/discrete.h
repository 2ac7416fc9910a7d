// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/discrete/inference.h"
#include "libhybrid/hybrid/graph.h"

namespace HYBRID_API hybrid {

/// Exact marginals of the discrete variables given the continuous estimate (eq. 11a). Throws Error
/// over the limits, and for a variable without a value.
DiscreteMarginals discrete_marginals(const HybridGraph& graph, const Values& values,
                                     const TableLimits& limits = {});

}  // namespace hybrid
