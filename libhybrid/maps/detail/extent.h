// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "libhybrid/maps/map_record.h"

namespace hybrid {

/// Of the place that a map has for a landmark, along an axis [m^2]: of several things each map may
/// have seen others, one thing is where it is.
inline double variance_of_extent(const MapLandmark& landmark) {
  return landmark.size.things > 1 ? landmark.size.extent * landmark.size.extent : 0;
}

}  // namespace hybrid
