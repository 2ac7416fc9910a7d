// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Landmarks as a map keeps them: those known before the first keyframe, and what is known of all
// in the end.

#include <algorithm>

#include "libhybrid/core/error.h"
#include "libhybrid/landmarks/count_things.h"
#include "libhybrid/landmarks/landmark_association.h"

namespace hybrid {
namespace {

// Numbers of landmarks that a map may have had, one after the other: some 300 bytes each are kept.
constexpr std::int64_t kMostIds = 1'000'000;

}  // namespace

void LandmarkAssociation::adopt(const KnownMap& known, bool is_3d) {
  for (const KnownLandmark& landmark : known.landmarks) {
    if (landmark.id >= 0 && landmark.id < kMostIds) continue;
    throw Error("landmark " + std::to_string(landmark.id) +
                " of the map has the id of a log, which numbers beyond 1,000,000 must be; use the "
                "plugin that made the map");
  }
  for (const KnownLandmark& landmark : known.landmarks) {
    if (landmark.size.extent <= options_.extent) continue;
    options_.extent = landmark.size.extent;  // the map is used as it was made
    options_.method = AssociationOptions::Method::kJcbb;
  }
  if (!known.class_names.empty()) now_.classes.learn_names(known.class_names);
  landmarks_.adopt(known.landmarks, now_.classes, is_3d);
  adopted_ = !known.landmarks.empty();
}

std::map<std::int64_t, double> LandmarkAssociation::existence() const {
  std::map<std::int64_t, double> out;
  for (int t = 0; t < static_cast<int>(landmarks_.tracks().size()); ++t) {
    if (landmarks_.track(t).alive) out[t] = landmarks_.track(t).existence;
  }
  return out;
}

std::map<std::int64_t, LandmarkSize> LandmarkAssociation::sizes(const MapView& map) const {
  const std::vector<int> things =
      count_things(map, now_.classes, loops_.views(), options_, landmarks_);
  std::map<std::int64_t, LandmarkSize> out;
  for (int t = 0; t < static_cast<int>(things.size()); ++t) {
    const Track& track = landmarks_.track(t);
    if (track.alive) out[t] = {track.extent, std::max(things[t], track.known_things)};
  }
  return out;
}

}  // namespace hybrid
