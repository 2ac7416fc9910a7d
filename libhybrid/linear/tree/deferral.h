// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/linear/tree/elimination.h"

namespace HYBRID_API hybrid {

/// Takes new variables and factors into the solution without an elimination: see BayesTree::defer.
/// Returns false, with nothing changed, where that cannot be done.
bool defer(const TreeParts& tree, const Charts* charts, EliminationWorkspace& workspace);

}  // namespace hybrid
