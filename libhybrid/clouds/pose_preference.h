// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/clouds/cloud_surfaces.h"

namespace HYBRID_API hybrid {

/// Logarithm of the odds that points, in the frame of the robot, were seen from pose `b` of a map
/// and not from `a`, by how many lie on its surfaces; negative where `a` is the likelier.
/// Points of one cube of edge `block` [m] are one observation. Only points count in whose direction
/// `known`, the same surfaces or coarser ones, has something from both poses: what is seen for the
/// first time tells nothing.
double preference(const std::vector<CloudPoint>& points, const CloudSurfaces& map,
                  const CloudSurfaces& known, const SE3& a, const SE3& b, double block);

}  // namespace hybrid
