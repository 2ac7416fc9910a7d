// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/landmarks/association_options.h"
#include "libhybrid/landmarks/class_model.h"
#include "libhybrid/landmarks/contribution.h"
#include "libhybrid/landmarks/landmark_tracks.h"
#include "libhybrid/landmarks/views.h"

namespace HYBRID_API hybrid {

/// How many things each track stands for, by the detections that single frames have of it: of K
/// things, each is detected with one probability, which is not known, and clutter comes on top
/// (binomial and Poisson). K is the most probable, where each more is half as probable beforehand.
/// Detections that are of no track count with the nearest one that their frame shows besides.
std::vector<int> count_things(const MapView& map, const ClassModel& classes, const Views& views,
                              const AssociationOptions& options, const LandmarkTracks& landmarks);

}  // namespace hybrid
