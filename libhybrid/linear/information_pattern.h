// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/core/assignment.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/linear/block_pattern.h"

namespace HYBRID_API hybrid {

/// The blocks of the information matrix J'J of a graph under an assignment: one for each variable
/// of a continuous factor or chosen component, in the order of their keys, an edge for each two
/// that share one. Weak components are left out, as solvers leave their off-diagonal blocks out.
BlockPattern information_pattern(const HybridGraph& graph, const Assignment& assignment);

}  // namespace hybrid
