// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/association/constellation.h"
#include "libhybrid/landmarks/association_options.h"
#include "libhybrid/landmarks/frame_association.h"
#include "libhybrid/landmarks/landmark_merging.h"
#include "libhybrid/landmarks/landmark_tracks.h"
#include "libhybrid/landmarks/views.h"

namespace HYBRID_API hybrid {

/// Recognises places: the landmarks first seen on the last stretch of the way, as a constellation,
/// among those about earlier poses, with all the drift between the two that the joint covariance
/// allows. What closes a loop is what several landmarks and their classes agree about.
class LoopClosing {
 public:
  explicit LoopClosing(const AssociationOptions& options) : options_(options) {}

  /// Notes where a sensor looked from a keyframe, `map` being that of its frame, and how far back
  /// the way has drifted too much. `density` is that of landmarks per m^2 or m^3.
  void looked(const KeyframeView& frame, const Eigen::Isometry3d& T_robot_sensor,
              const SensorCoverage& coverage, double density, const MapView& map);

  /// From here on `looked` can be taken back.
  void remember() { before_ = {views_.size(), first_recent_}; }
  void take_back();

  /// The pose that begins the last stretch: since then the way has drifted by so little that where
  /// a landmark may be there is less than one other by chance.
  Key recent_since() const { return views_[first_recent_].pose; }

  /// All looks so far.
  const Views& views() const { return views_; }

  /// Landmarks of the last stretch that are others of the map, or none. Looks again only once there
  /// is another landmark than those of the last `note`. `density` is that of landmarks per m^2 or
  /// m^3.
  Merge propose(const MapView& map, const ClassModel& classes, double density, bool concluding,
                const LandmarkTracks& landmarks) const;
  /// Notes that it was asked for.
  void note(bool concluding, const LandmarkTracks& landmarks);

 private:
  template <class Pose>
  Merge propose_among(int sightings, const MapView& map, const ClassModel& classes, double density,
                      bool concluding, const LandmarkTracks& landmarks) const;
  template <class Pose>
  std::vector<int> ask_about(std::size_t view, int sightings, const MapView& map,
                             const LandmarkTracks& landmarks,
                             ConstellationMatchProblem<Pose>& question) const;
  double chance(const View& view, const KeyframeView& frame, double density,
                const MapView& map) const;
  std::vector<int> recent_tracks(int sightings, const MapView& map,
                                 const LandmarkTracks& landmarks) const;
  std::vector<std::size_t> anchors(const MapView& map, double radius) const;
  std::vector<std::size_t> anchors_within(const MapView& map, double radius) const;
  std::vector<int> tracks_about(const Eigen::Vector3d& center, int sightings, const MapView& map,
                                const LandmarkTracks& landmarks) const;
  bool is_old(int track, const LandmarkTracks& landmarks) const;
  bool is_clutter(const LandmarkTracks& landmarks) const;
  bool covered(const Eigen::Vector3d& point, const std::vector<std::size_t>& views,
               const MapView& map) const;
  double span() const;

  AssociationOptions options_;
  Views views_;
  std::size_t first_recent_ = 0;  // view with which the last stretch begins
  std::size_t asked_ = 0;         // tracks that there were when last asked, one more at the end
  struct {
    std::size_t views = 0, first_recent = 0;
  } before_;  // when told to remember
};

}  // namespace hybrid
