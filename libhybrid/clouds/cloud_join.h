// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libhybrid/clouds/cloud_closures.h"
#include "libhybrid/maps/join_maps.h"

namespace HYBRID_API hybrid {

/// The clouds of a map, by its local clouds.
std::vector<StoredCloud> stored_clouds(const MapRecord& map);

/// All that stored clouds show, in the map: points nearer to each other than the widest spacing are
/// one.
std::vector<CloudPoint> surfaces_of(const std::vector<StoredCloud>& stored);

/// Joins two maps in space by the clouds that both have, as join_maps_by_scans() does those in the
/// plane by scans. Nothing where no place stands out with these `odds`; `why` tells what speaks
/// against it. Throws Error as join_maps().
std::optional<JoinedMaps> join_maps_by_clouds(const MapRecord& first, const MapRecord& second,
                                              double odds, std::string& why);

}  // namespace hybrid
