// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace hybrid {

/// A sighting in the frame of the map, placed by the true pose.
struct PlacedSighting {
  Eigen::Vector3d place;        ///< in the map [m]
  std::size_t class_index = 0;  ///< a landmark has sightings of one class only
};

/// Landmark ids of sightings by their positions, one after the other: a sighting belongs to the
/// landmark of its class with the nearest mean within `radius` [m], or begins a new landmark.
/// Returns one id per sighting, mrpt::obs::INVALID_LANDMARK_ID for landmarks with fewer than
/// `least` sightings.
std::vector<std::int32_t> number_by_place(const std::vector<PlacedSighting>& sightings,
                                          double radius, std::size_t least);

}  // namespace hybrid
