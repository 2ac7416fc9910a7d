// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/maps/place_map.h"

namespace hybrid {

/// A guess of where `here` is in the map.
template <class Pose>
struct PlaceSeed {
  Pose T_map_here;
  int anchor = 0;  ///< landmark of the map that the guess is from
  double score = 0;
};

/// The most promising guesses, best first, none near a better one.
template <class Pose>
std::vector<PlaceSeed<Pose>> place_seeds(const PlaceQuestion<Pose>& question, double density,
                                         std::size_t most);

}  // namespace hybrid
