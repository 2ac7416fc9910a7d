// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "libhybrid/core/key.h"
#include "libhybrid/geometry/known_place.h"
#include "libhybrid/hybrid/graph.h"
#include "libhybrid/smoother/incremental.h"

namespace HYBRID_API hybrid {

/// The variable of a known place in a graph: a stretch of an earlier map. It has one error, however
/// often it is matched.
inline Key place_key(std::size_t place) {
  return {'p', place};
}

/// Where variable b of a graph is, seen from a.
template <class Pose>
Uncertain<Pose> relation_of(Key a, Key b, const IncrementalSmoother& smoother);

/// Place i and those beside which it is known, as far as a graph does not hold them; each comes
/// after the one beside which it is known.
template <class Pose>
std::vector<std::size_t> missing_places(const std::vector<KnownPlace<Pose>>& places, std::size_t i,
                                        const std::function<bool(std::size_t place)>& is_held);

/// Where a place is, seen from its parent.
template <class Pose>
Uncertain<Pose> beside_parent(const std::vector<KnownPlace<Pose>>& places, std::size_t i);

/// The variables of places.
using PlaceKeys = std::function<Key(std::size_t place)>;

/// What is known of a place: where it is beside its parent; without one, where it is in the frame
/// of the map.
template <class Pose>
ContinuousFactorPtr factor_of_place(const std::vector<KnownPlace<Pose>>& places, std::size_t i,
                                    const PlaceKeys& key = place_key);

/// Where a pose is, seen from a place. While the graph holds none of those beside which this is
/// known, as if the errors of both in the frame of the map were independent.
template <class Pose>
Uncertain<Pose> relation_to_place(const std::vector<KnownPlace<Pose>>& places, std::size_t i,
                                  Key pose, const IncrementalSmoother& smoother,
                                  const PlaceKeys& key = place_key);

/// Adds place i to a change of a graph, and those beside which it is known, as far as the graph and
/// the change do not hold them.
void insert_place(const std::vector<KnownPlace<SE2>>& places, std::size_t i, const Values& graph,
                  Delta& change);
void insert_place(const std::vector<KnownPlace<SE3>>& places, std::size_t i, const Values& graph,
                  Delta& change);

}  // namespace hybrid
