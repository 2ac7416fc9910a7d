// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/maps/map_record.h"
#include "libhybrid/scans/laser_scan.h"
#include "mrpt_plugins/bridge/timed_pose.h"
#include "mrpt_plugins/mapping/grid_map.h"
#include "mrpt_plugins/output/scan_map.h"

namespace HYBRID_API hybrid {

/// The local maps of a map file as scans: from keyframes along the stretch of each, the nearest of
/// its surfaces in all directions.
struct StoredViews {
  Trajectory poses;
  std::vector<LaserScan> scans;  ///< one for each pose
};
StoredViews stored_views(const MapRecord& map);

/// The grid of these, and of scans of a session with its keyframes, which may be none; empty where
/// nothing has a return.
GridMap draw_grid(const StoredViews& views, const std::vector<KeyframeScans>& scans,
                  const Trajectory& keyframes);

}  // namespace hybrid
