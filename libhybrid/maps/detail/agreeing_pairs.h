// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "libhybrid/maps/detail/joint_estimate.h"

namespace hybrid {

/// Of pairs of landmarks that are one by their ids, those that also lie so: the pair that disagrees
/// most with all others is left out, again and again, as long as it does by more than chance allows
/// (data snooping, Baarda 1968). What chance allows is what the maps say of themselves, times the
/// variance factor of the others, since maps of real logs are too sure of themselves. `T` is about
/// where the second map is in the first.
template <class Pose>
LandmarkPairs agreeing_pairs(const MapRecord& first, const MapRecord& second, LandmarkPairs pairs,
                             Pose T);

}  // namespace hybrid
