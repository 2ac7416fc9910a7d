// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <vector>

#include "libhybrid/landmarks/association_decision.h"
#include "libhybrid/landmarks/frame_association.h"
#include "libhybrid/landmarks/landmark_events.h"
#include "libhybrid/landmarks/moving_things.h"
#include "libhybrid/landmarks/open_matchings.h"

namespace HYBRID_API hybrid {

/// Notes what became of the sightings of a frame and why: of all `noted` ones, and of those that
/// had to be matched.
void explain_frame(const LandmarkTracks& landmarks, const std::vector<int>& noted,
                   const FrameMatching& matching, const ClassModel& classes, LandmarkEvents& out);

/// A detection of the landmark that the log gives this id; with the NIS of its innovation where
/// that landmark is in the map and the map has a covariance.
SightingEvent identified_sighting(const KeyframeView& frame, const DetectionFrame& seen,
                                  const Detection& detection, std::int64_t id, const MapView& map);

/// What became of every detection so far, in order, for evaluation; those of frames that are open
/// as their variables have it now.
std::vector<AssociationDecision> decisions(const MapView& map, const OpenMatchings& open,
                                           const MovingThings& movers,
                                           const LandmarkTracks& landmarks);

}  // namespace hybrid
