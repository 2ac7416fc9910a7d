// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <vector>

#include "libhybrid/maps/map_record.h"
#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/mapping/mapper.h"
#include "mrpt_plugins/settings/replay_settings.h"

namespace HYBRID_API hybrid {

using Plugins = std::vector<std::shared_ptr<MappingPlugin>>;

/// Whether a map has scans that robots in the plane can be located by.
bool has_planar_scans(const MapRecord& map);
/// Whether it has clouds that robots in space can be located by.
bool has_clouds(const MapRecord& map);

/// The covariance of a pose in the plane, or in space; a default where it is not known.
Eigen::Matrix3d planar_covariance(const Eigen::MatrixXd& covariance);
Matrix6d spatial_covariance(const Eigen::MatrixXd& covariance);

/// Before the first keyframe: gives the plugins that follow scans or clouds those of a map that all
/// robots are in, which is of their kind.
void adopt_places(const Plugins& plugins, const MapRecord& map,
                  const std::vector<RobotSettings>& robots);

/// What laser scans and clouds saw, for a map file; the session is left at 0. Their parents count
/// the places of the map that the session was in first.
struct SeenPlaces {
  std::vector<MapLocalMap> local_maps;
  std::vector<MapLocalCloud> local_clouds;
};
SeenPlaces seen_places(const Plugins& plugins, const MapResult& result, const Mapper& mapper,
                       std::size_t known_places = 0);

}  // namespace hybrid
