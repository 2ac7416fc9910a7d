// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// A point cloud: positions in one frame and one unit of length.
using Points = std::vector<Eigen::Vector3d>;

}  // namespace hybrid
