// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <set>
#include <vector>

#include "libhybrid/detections/class_model.h"
#include "libhybrid/detections/sensor_coverage.h"
#include "libhybrid/landmarks/association_options.h"
#include "libhybrid/landmarks/contribution.h"
#include "libhybrid/landmarks/landmark_tracks.h"
#include "libhybrid/movers/thing_tracker.h"

namespace HYBRID_API hybrid {

/// Follows what is seen, and takes the sightings of things that move from the landmarks.
class MovingThings {
 public:
  /// Why a detection is not used.
  static constexpr const char* kDropped = "detection dropped: its thing moves";

  explicit MovingThings(const AssociationOptions& options)
      : options_(options), things_(options.motion) {}

  /// Follows the things of a frame, whose sightings are `noted`, and marks those of what moves.
  void take(const std::vector<int>& noted, const KeyframeView& frame,
            const SensorCoverage& coverage, const ClassModel& classes, const MapView& map,
            LandmarkTracks& landmarks);
  /// Decides about all things by all their sightings, once after the last frame.
  void decide(const MapView& map, const LandmarkTracks& landmarks);
  /// Takes the sightings of things that turned out to move from their landmarks. Those of
  /// `undecided` sightings, and those of a landmark that one of these may be of, wait for the
  /// decision.
  void withdraw(const std::set<int>& undecided, const MapView& map, LandmarkTracks& landmarks,
                Contribution& out);

  /// From here on the frames that are taken can be taken back.
  void remember();
  void take_back();

  /// The id of the mover that a sighting is of.
  std::optional<std::int64_t> mover_of(int sighting) const { return things_.mover_of(sighting); }
  /// All things that move, at those of the `times` at which they were in sight.
  std::vector<Mover> movers(const std::vector<double>& times, const MapView& map,
                            const LandmarkTracks& landmarks) const {
    return things_.movers(times, locate(map, landmarks));
  }

 private:
  struct Now {
    std::optional<Key> pose;  // of the last frame
    Eigen::MatrixXd motion;   // tangent covariance of that since the frame before it
    bool is_decided = false;
  };

  static ThingTracker::Locate locate(const MapView& map, const LandmarkTracks& landmarks,
                                     const KeyframeView* frame = nullptr);

  AssociationOptions options_;
  ThingTracker things_;
  Now now_, before_;
  std::set<int> to_withdraw_;  // sightings of movers that landmarks still have
};

}  // namespace hybrid
