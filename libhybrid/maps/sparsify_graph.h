// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/hybrid/graph.h"
#include "libhybrid/maps/sparse_gaussian.h"

namespace HYBRID_API hybrid {

/// The joint density of some points of a graph, all other variables integrated out, as sparsify()
/// splits a joint covariance. Of more than a thousand points each is given at most 32, of the 64
/// before it that are nearest: time and memory are then those of a sparse factorisation. Throws
/// Error where the graph does not determine its variables.
SparseGaussian sparsify(const HybridGraph& graph, const Values& values,
                        const std::vector<Key>& points, int dim, double most_loss = 0.1);

}  // namespace hybrid
