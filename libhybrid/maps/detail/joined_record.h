// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "libhybrid/maps/detail/joint_estimate.h"
#include "libhybrid/maps/joined_maps.h"

namespace hybrid {

/// Fills in the map of two maps and their landmarks that contradict each other, from the estimate
/// of all landmarks together and the motion in `out`.
template <class Pose>
void record_join(const MapRecord& first, const MapRecord& second, const LandmarkPairs& pairs,
                 const JointEstimate<Pose>& joint, JoinedMaps& out);

}  // namespace hybrid
