// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "libhybrid/linear/sparsity.h"
#include "libhybrid/smoother/incremental.h"
#include "mrpt_plugins/bridge/output_directory.h"

namespace HYBRID_API hybrid {

/// Writes pictures of the structure of a graph, one dot per block of a variable or factor:
/// sparsity_jacobian.png, sparsity_information.png, sparsity_factor.png (the Cholesky factor with
/// fill-in, for the given elimination order of the variables) and sparsity_marginalized.png (the
/// information matrix before and after the older half of the poses is marginalised). Without an
/// order, a fill-reducing one is used. Variables without an active factor are left out. Returns
/// warnings for the user: a marginalisation with too many blocks is not drawn. Throws Error for a
/// graph without continuous factors or an order that lacks variables.
std::vector<std::string> write_sparsity(const OutputDirectory& out, const HybridGraph& graph,
                                        const Assignment& assignment, const std::vector<Key>& order,
                                        const std::string& title);

}  // namespace hybrid
