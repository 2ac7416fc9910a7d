// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <string>
#include <vector>

#include "libhybrid/detections/class_model.h"
#include "libhybrid/detections/sensor_coverage.h"
#include "libhybrid/landmarks/association_options.h"
#include "libhybrid/landmarks/contribution.h"
#include "libhybrid/landmarks/landmark_tracks.h"

namespace HYBRID_API hybrid {

/// A sighting that belongs to another track than it was taken for; to none, as clutter: -1.
struct Reassignment {
  int sighting, track;
};

/// The discrete half-step of eq. 8 over the associations of all frames: given the estimate, each
/// frame has a matching of least cost -log p, and what differs in it from the present one is
/// returned where that costs less. Sightings that the log names by an id are of the track of that
/// id in `track_of_id`, or misread: clutter. `coverage` is by label of the sensor.
std::vector<Reassignment> reassociate(const MapView& map, const ClassModel& classes,
                                      const std::map<std::string, SensorCoverage>& coverage,
                                      const AssociationOptions& options,
                                      const std::map<std::int64_t, int>& track_of_id,
                                      const LandmarkTracks& landmarks);

}  // namespace hybrid
