// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/detections/sensor_coverage.h"
#include "libhybrid/landmarks/association_options.h"
#include "libhybrid/landmarks/contribution.h"
#include "libhybrid/landmarks/landmark_tracks.h"

namespace HYBRID_API hybrid {

/// Log odds that a landmark of one detection is there.
double existence_at_birth(const AssociationOptions& options);

/// Landmarks that a look at the map from here, at a keyframe, should have shown and did not; of
/// those made by sightings the ones seen in the `recent` keyframes before.
std::vector<int> missed_landmarks(const Eigen::Isometry3d& T_map_sensor,
                                  const SensorCoverage& coverage, const MapView& map, int keyframe,
                                  int recent, const LandmarkTracks& landmarks);

/// Raises the odds of landmarks that a frame shows by `sightings` and lowers those of landmarks
/// that it `missed`; `coverage`, which is that of its sensor, learns how often it detects.
/// Returns the tentative landmarks that are improbable by now: they were clutter.
std::vector<int> judge_existence(const std::vector<int>& sightings, const std::vector<int>& missed,
                                 const MapView& map, const AssociationOptions& options,
                                 SensorCoverage& coverage, LandmarkTracks& landmarks);

/// The landmarks that are tentative or improbable once no more keyframes come. Those named by an
/// id, which clutter is not, are probable; what becomes of known ones is for the map to say.
std::vector<int> never_confirmed(const AssociationOptions& options,
                                 const LandmarkTracks& landmarks);

}  // namespace hybrid
