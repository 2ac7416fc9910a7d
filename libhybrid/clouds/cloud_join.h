// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libhybrid/clouds/cloud_closures.h"
#include "libhybrid/maps/join_maps.h"
#include "libhybrid/online/join_graph.h"

namespace HYBRID_API hybrid {

/// The clouds of a map, by its local clouds.
std::vector<StoredCloud> stored_clouds(const MapRecord& map);

/// All that stored clouds show, in the map: points nearer to each other than the widest spacing are
/// one.
std::vector<CloudPoint> surfaces_of(const std::vector<StoredCloud>& stored);

/// Where local clouds of one map are in those of another, of which it is roughly known where its
/// frame is: matches that agree with each other.
std::vector<PlaceMatch<SE3>> common_places(const std::vector<StoredCloud>& first,
                                           const std::vector<StoredCloud>& second,
                                           const UncertainMotion3& T_first_second);

/// Joins two maps in space by the clouds that both have, as join_maps_by_scans() does those in the
/// plane by scans. Nothing where no place stands out with these `odds`; `why` tells what speaks
/// against it. Throws Error as join_maps().
std::optional<JoinedMaps> join_maps_by_clouds(const MapRecord& first, const MapRecord& second,
                                              double odds, std::string& why);

/// By clouds in space, and by laser scans in the plane; where one of the maps has none, nothing,
/// and `why` stays empty.
std::optional<JoinedMaps> join_maps_by_places(const MapRecord& first, const MapRecord& second,
                                              double odds, std::string& why);

}  // namespace hybrid
