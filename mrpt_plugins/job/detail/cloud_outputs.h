// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <vector>

#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/mapping/cloud_follower.h"

namespace hybrid {

/// Adds what clouds saw, and the closures that they made, to the result.
void add_clouds(const std::vector<std::shared_ptr<MappingPlugin>>& plugins, MapResult& result);

/// Writes cloud.ply and cloud.pcd where there are clouds, and cloud_loops.csv where these made
/// closures.
void write_clouds(const OutputDirectory& out,
                  const std::vector<std::shared_ptr<MappingPlugin>>& plugins,
                  const MapResult& result);

}  // namespace hybrid
