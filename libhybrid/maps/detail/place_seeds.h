// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/maps/find_place.h"

namespace hybrid {

/// A guess of where `here` is in the map.
template <class Pose>
struct PlaceSeed {
  Pose T_map_here;
  int anchor = 0;  ///< landmark of the map that the guess is from
  double score = 0;
};

/// Density of the landmarks where there are some, per m^2 or m^3: the median over them of that
/// within the distance of the fifth nearest.
template <class Point>
double local_density(const std::vector<Point>& points);

/// The most promising guesses, best first, none near a better one.
template <class Pose>
std::vector<PlaceSeed<Pose>> place_seeds(const PlaceQuestion<Pose>& question, double density,
                                         std::size_t most);

}  // namespace hybrid
