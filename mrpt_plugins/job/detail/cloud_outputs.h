// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <vector>

#include "libhybrid/maps/map_record.h"
#include "mrpt_plugins/bridge/output_directory.h"
#include "mrpt_plugins/mapping/cloud_follower.h"
#include "mrpt_plugins/mapping/mapper.h"

namespace hybrid {

/// Adds what clouds saw, with those of the `known` map that the robots are in, and the closures
/// that they made, to the result.
void add_clouds(const std::vector<std::shared_ptr<MappingPlugin>>& plugins, const MapRecord& known,
                MapResult& result);

/// What clouds saw along stretches of the path; nothing where no plugin follows clouds.
std::vector<LocalView> views_of(const std::vector<std::shared_ptr<MappingPlugin>>& plugins);

/// Writes cloud.ply, cloud.pcd and map.simplemap where there are clouds, and cloud_loops.csv where
/// these made closures.
void write_clouds(const OutputDirectory& out,
                  const std::vector<std::shared_ptr<MappingPlugin>>& plugins,
                  const MapResult& result, const Mapper& mapper);

}  // namespace hybrid
