// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "mrpt_plugins/mapping/cloud_follower.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/output/scan_map.h"

namespace HYBRID_API hybrid {

/// What lasers saw at keyframes, for a page: points in the frame of the robot [m], ten centimetres
/// apart, and of each scan every n-th of these where there would be more than `most_points`.
nlohmann::ordered_json scans_json(const std::vector<KeyframeScans>& scans,
                                  std::size_t most_points = 150000);

/// The same of what clouds saw along stretches of the path: walls and poles, turned so that the z
/// axis points up.
nlohmann::ordered_json views_json(const std::vector<LocalView>& views, const Trajectory& keyframes,
                                  std::size_t most_points = 150000);

/// The closures as columns.
nlohmann::ordered_json scan_closures_json(const std::vector<ScanClosureEstimate>& closures);

}  // namespace hybrid
