// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "libhybrid/association/gate.h"
#include "libhybrid/detections/class_model.h"
#include "libhybrid/landmarks/contribution.h"
#include "libhybrid/landmarks/landmark_tracks.h"

namespace HYBRID_API hybrid {

/// How well the sightings of a map fit its landmarks where it has them now: under the noise of the
/// detection and the extent of the landmark, the map being known.
class SightingCosts {
 public:
  SightingCosts(const MapView& map, const ClassModel& classes, const LandmarkTracks& landmarks)
      : map_(map), classes_(classes), landmarks_(landmarks) {}

  /// Of range and direction of sighting `s` as one of track `t`.
  GaussianScore place(int s, int t) const;
  /// -log p(class scores) as one of track `t`, up to a constant of the scores.
  double classes(int s, int t) const;
  /// The same as of a landmark not seen before, or of clutter.
  double unknown_classes(int s) const;

 private:
  const MapView& map_;
  const ClassModel& classes_;
  const LandmarkTracks& landmarks_;
};

}  // namespace hybrid
