// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cstddef>
#include <vector>

#include "libhybrid/geometry/points.h"

namespace HYBRID_API hybrid {

/// Indices of at most `most` of the points, of all where they are no more: of the first in each
/// voxel, in their order. The voxels are as small as that allows, of edges a factor of 2^(1/8)
/// apart, from 1 mm on, and begin at the least coordinates of the cloud. All points are finite.
std::vector<std::size_t> thin_points(const Points& points, std::size_t most);

}  // namespace hybrid
