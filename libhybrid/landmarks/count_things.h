// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "libhybrid/detections/class_model.h"
#include "libhybrid/landmarks/association_options.h"
#include "libhybrid/landmarks/contribution.h"
#include "libhybrid/landmarks/landmark_tracks.h"
#include "libhybrid/landmarks/sighting_costs.h"
#include "libhybrid/landmarks/views.h"

namespace HYBRID_API hybrid {

/// How many things landmarks stand for, by the detections that single frames have of them: of K
/// things, each is detected with one probability, which is not known, and clutter comes on top
/// (binomial and Poisson). Each thing more is half as probable beforehand. Detections that are of
/// no track count with the nearest one that their frame shows besides.
class ThingCounter {
 public:
  ThingCounter(const MapView& map, const ClassModel& classes, const Views& views,
               const AssociationOptions& options, const LandmarkTracks& landmarks);

  /// The most probable number of things that tracks at one place stand for together.
  int count(const std::vector<int>& tracks) const;
  /// log odds that they are fewer things than tracks, so that one of them at least is a copy.
  double log_odds_of_fewer(const std::vector<int>& tracks) const;

 private:
  void take(const std::vector<int>& sightings);
  int nearest(int s, const std::map<int, int>& tracks) const;
  double space_about(int t) const;
  std::vector<double> log_probabilities(const std::vector<int>& tracks, int at_least) const;

  const MapView& map_;
  const Views& views_;
  const AssociationOptions& options_;
  const LandmarkTracks& landmarks_;
  SightingCosts costs_;
  int dim_;
  double gate_;
  std::vector<std::map<int, int>> detections_;  // by track, by frame that has some
};

/// What each landmark stands for, by id: its extent, and the most probable number of things, or
/// that known before where it is larger.
std::map<std::int64_t, LandmarkSize> landmark_sizes(const MapView& map, const ClassModel& classes,
                                                    const Views& views,
                                                    const AssociationOptions& options,
                                                    const LandmarkTracks& landmarks);

}  // namespace hybrid
