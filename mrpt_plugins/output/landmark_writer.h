// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// Landmarks as CSV with a heading: id, x, y, z (m), the upper triangle of the covariance (m^2),
/// class (empty if none), sightings, then `p_<class>` for every class. A landmark without
/// probabilities leaves those columns empty. Throws std::invalid_argument on a class index or a
/// number of probabilities that does not fit `class_names`.
std::string landmarks_csv(const MapResult& result);

/// The same as JSON: {"dimension": 2|3, "classes": [...], "landmarks": [{"id", "position",
/// "covariance", "class", "class_probabilities": {name: p}, "sightings"}]}. Positions and
/// covariances have as many coordinates as the map has dimensions. Values that are not finite
/// become null.
std::string landmarks_json(const MapResult& result);

}  // namespace hybrid
