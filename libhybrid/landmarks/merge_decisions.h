// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>

#include "libhybrid/landmarks/landmark_merging.h"
#include "libhybrid/landmarks/loop_closing.h"

namespace HYBRID_API hybrid {

/// Which merge of landmarks is tried next, and what became of it: the generators of merges in the
/// order in which they are asked, and the one merge that is on trial.
class MergeDecisions {
 public:
  explicit MergeDecisions(const AssociationOptions& options) : merging_(options), loops_(options) {}

  /// Notes where a sensor looked from a keyframe, see LoopClosing::looked.
  void looked(const KeyframeView& frame, const Eigen::Isometry3d& T_robot_sensor,
              const SensorCoverage& coverage, double density, const MapView& map) {
    loops_.looked(frame, T_robot_sensor, coverage, density, map);
  }
  /// Notes that a landmark was sighted at this keyframe.
  void sighted(int track, int keyframe, const LandmarkTracks& landmarks) {
    merging_.sighted(track, keyframe, landmarks.track(track).sightings.size());
  }
  /// Forgets landmarks that are not recent any more at this keyframe.
  void forget(int keyframe) { merging_.forget(keyframe); }

  /// All looks so far.
  const Views& views() const { return loops_.views(); }
  /// The pose that begins the last stretch of the way.
  Key recent_since() const { return loops_.recent_since(); }

  /// The next merge of landmarks seen lately, or of any, that is to be tried; no pairs: none.
  /// `density` is that of landmarks per m^2 or m^3.
  Merge next(const MapView& map, const ClassModel& classes, double density, int keyframe,
             bool everything, const LandmarkTracks& landmarks);
  /// The same by what all looks showed and missed, once nothing else is found at the end.
  Merge next_by_looks(const MapView& map, const ClassModel& classes, double density,
                      const LandmarkTracks& landmarks);
  /// Makes the landmarks one, on trial. What a merge is worth shows in the objective only once the
  /// map has settled: it may move as far as the drift, over which one linear step does not come.
  Contribution try_out(const Merge& merge, const MapView& map, LandmarkTracks& landmarks);

  /// The last contribution is in the graph. Returns the merge that was on trial, if there was one.
  std::optional<Merge> applied(const LandmarkTracks& landmarks);
  /// It is not; `landmarks` are again as before. Whether a merge was on trial: it is not proposed
  /// again while nothing new is seen.
  bool refused(const LandmarkTracks& landmarks);

  /// From here on what is noted can be taken back.
  void remember();
  void take_back();

 private:
  void keep_whole(const MapView& map, const LandmarkTracks& landmarks, Merge& merge);

  LandmarkMerging merging_;
  LoopClosing loops_;
  std::optional<Merge> on_trial_;
};

}  // namespace hybrid
