// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "mrpt_plugins/map_file/map_file.h"
#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// The place on the globe of a map whose place fixes have found.
MapOrigin origin_of(const MapDatum& datum);
/// The reverse.
MapDatum datum_of(const MapOrigin& origin);

/// Where the second of two maps is in the first, in the plane unless they are in space; nothing
/// unless fixes have told the places of both.
std::optional<Eigen::Isometry3d> motion_by_fixes(const std::optional<MapOrigin>& first,
                                                 const std::optional<MapOrigin>& second,
                                                 bool is_3d);

/// The keyframes of one robot in one session.
struct MapWay {
  int session = 0;
  std::string robot;  ///< empty where it has no name
  Trajectory poses;
};

/// Those of all sessions and robots, in this order.
std::vector<MapWay> ways_of(const MapRecord& map);

/// The landmarks that exist, the grid of the local maps, and all ways; each robot has one colour,
/// and where there are several sessions each of robots without a name.
MapResult result_of(const MapRecord& map, const std::string& title);

/// Landmarks that exist as points, and each way as a line (RFC 7946: longitude and latitude by
/// WGS 84).
std::string geojson_text(const MapRecord& map, const MapOrigin& origin);
/// Landmarks as points, paths as lines, and fixes as points where the receiver says that it is.
std::string geojson_text(const MapResult& result, const MapOrigin& origin);

/// Landmarks that exist as a point cloud: x y z [m], number of the class (-1: none), id.
std::string pcd_text(const MapRecord& map);

}  // namespace hybrid
