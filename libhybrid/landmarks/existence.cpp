// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/existence.h"

#include <algorithm>
#include <cmath>

#include "libhybrid/core/spatial_values.h"

namespace hybrid {
namespace {

constexpr double kSureOdds = 12.0;  // log odds of existence above which they do not grow

}  // namespace

std::vector<int> missed_landmarks(const Eigen::Isometry3d& T_map_sensor,
                                  const SensorCoverage& coverage, const MapView& map, int keyframe,
                                  int recent, const LandmarkTracks& landmarks) {
  std::vector<int> missed;
  landmarks.grid().visit_near(
      T_map_sensor.translation().x(), T_map_sensor.translation().y(), coverage.max_range,
      [&](int t) {
        const Track& track = landmarks.track(t);
        // Where a landmark lies that was last seen long ago is known less well than this asks for.
        const bool long_ago = track.last_keyframe + recent < keyframe;
        if ((long_ago && track.known_sightings == 0) || !map.holds(track.position)) return;
        if (track.last_keyframe == keyframe || track.open > 0) return;
        if (coverage.well_in_view(T_map_sensor, point_at(map.values, track.position))) {
          missed.push_back(t);
        }
      });
  return missed;
}

double existence_at_birth(const AssociationOptions& options) {
  return std::log(options.landmarks_in_view / options.clutter_in_view);
}

std::vector<int> judge_existence(const std::vector<int>& sightings, const std::vector<int>& missed,
                                 const MapView& map, const AssociationOptions& options,
                                 SensorCoverage& coverage, LandmarkTracks& landmarks) {
  const double detected = coverage.detection_probability(options.detection_probability);
  // Clutter in the share of the view that is nearest to a landmark is taken for it.
  const double clutter = std::min(
      detected, options.clutter_in_view / coverage.expected_in_view(options.landmarks_in_view));
  double seen_now = 0;
  for (const int s : sightings) {
    const int t = landmarks.sighting(s).track;
    if (t < 0) continue;
    ++seen_now;
    const double odds = landmarks.track(t).existence + std::log(detected / clutter);
    landmarks.set(t, &Track::existence, std::min(kSureOdds, odds));
  }
  const double in_view = seen_now + static_cast<double>(missed.size());
  coverage.detections += seen_now;
  coverage.around += seen_now * in_view;
  coverage.in_view += in_view;
  coverage.seen += seen_now;
  const double miss = std::log((1 - detected) / (1 - clutter));
  std::vector<int> clutter_tracks;
  for (const int t : missed) {
    const Track& track = landmarks.track(t);
    landmarks.set(t, &Track::existence, track.existence + miss);
    const bool tentative = !landmarks.seen_times(t, options.confirm) && track.known_sightings == 0;
    if (tentative && track.existence < -std::log(options.clutter_odds) && map.keeps_all) {
      clutter_tracks.push_back(t);
    }
  }
  return clutter_tracks;
}

std::vector<int> never_confirmed(const AssociationOptions& options,
                                 const LandmarkTracks& landmarks) {
  std::vector<int> out;
  for (int t = 0; t < static_cast<int>(landmarks.tracks().size()); ++t) {
    const Track& track = landmarks.track(t);
    if (!track.alive || track.known_sightings > 0) continue;
    const bool named = options.use_ids && landmarks.has_id(t);
    const bool there = track.existence > 0 || named;
    if (!(landmarks.seen_times(t, options.confirm) && there)) out.push_back(t);
  }
  return out;
}

}  // namespace hybrid
