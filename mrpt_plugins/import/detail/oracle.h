// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace hybrid {

/// Where the true pose puts a sighting, and what it looks like.
struct PlacedSighting {
  Eigen::Vector3d place;        ///< in the map [m]
  std::size_t class_index = 0;  ///< sightings of different classes are of different landmarks
};

/// Numbers landmarks by where their sightings lie, one after the other: each belongs to the nearest
/// mean of its class within `radius` [m], or begins a new one. Landmarks with less than `least`
/// sightings do not count. One number per sighting, mrpt::obs::INVALID_LANDMARK_ID for none.
std::vector<std::int32_t> number_by_place(const std::vector<PlacedSighting>& sightings,
                                          double radius, std::size_t least);

}  // namespace hybrid
