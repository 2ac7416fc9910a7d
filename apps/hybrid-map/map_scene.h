// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "libhybrid/maps/map_record.h"

namespace hybrid {

/// A map as a file in MCAP, which Foxglove shows: messages foxglove.SceneUpdate in JSON on the
/// topic /hybrid/map. The first has the landmarks that exist, each as a sphere with its class, a
/// text and the ellipsoid of 3 standard deviations, and the paths as lines; then there is one for
/// each keyframe, with an arrow where the robot was. The file has no index.
std::string mcap_of(const MapRecord& map);

}  // namespace hybrid
