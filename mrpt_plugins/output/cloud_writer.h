// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>
#include <vector>

#include "libhybrid/clouds/cloud_points.h"
#include "mrpt_plugins/mapping/cloud_follower.h"
#include "mrpt_plugins/mapping/grid_map.h"

namespace HYBRID_API hybrid {

/// Points with their normals: x y z nx ny nz, little endian single precision [m].
std::string cloud_ply(const std::vector<CloudPoint>& points);
/// The same for PCL.
std::string cloud_pcd(const std::vector<CloudPoint>& points);

/// Where walls are, seen from above; empty where there are none. No cell is free.
GridMap cloud_grid(const std::vector<CloudPoint>& points);

/// A row per closure: keyframes i and j, its decision, and the pose of j in the frame of i
/// [m, rad].
std::string cloud_closures_csv(const std::vector<MeasuredClosure<SE3>>& closures);

}  // namespace hybrid
