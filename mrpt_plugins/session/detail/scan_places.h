// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <vector>

#include "libhybrid/maps/map_record.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/settings/replay_settings.h"

namespace hybrid {

using Plugins = std::vector<std::shared_ptr<MappingPlugin>>;

/// Whether a map has scans that robots in the plane can be located by.
bool has_planar_scans(const MapRecord& map);

/// The covariance of a pose in the plane; a default where it is not known.
Eigen::Matrix3d planar_covariance(const Eigen::MatrixXd& covariance);

/// Before the first keyframe: gives the plugins that follow scans those of a map that all robots
/// are in. Nothing where it has none, or is in space.
void adopt_scans(const Plugins& plugins, const MapRecord& map,
                 const std::vector<RobotSettings>& robots);

/// What laser scans saw, for a map file; the session is left at 0.
std::vector<MapLocalMap> local_maps(const Plugins& plugins, const MapResult& result,
                                    const Mapper& mapper);

}  // namespace hybrid
