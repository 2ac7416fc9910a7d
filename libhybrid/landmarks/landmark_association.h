// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/core/journaled_map.h"
#include "libhybrid/landmarks/association_decision.h"
#include "libhybrid/landmarks/association_options.h"
#include "libhybrid/landmarks/count_things.h"
#include "libhybrid/landmarks/explain.h"
#include "libhybrid/landmarks/landmark_tracks.h"
#include "libhybrid/landmarks/merge_decisions.h"
#include "libhybrid/landmarks/moving_things.h"
#include "libhybrid/landmarks/open_matchings.h"

namespace HYBRID_API hybrid {

/// Range and bearing to landmarks that the sensor does not identify, with or without classes: which
/// sighting belongs to which landmark is part of what is estimated (eq. 18-19). Landmarks are
/// tentative until they were seen often enough, and made one where they turn out to be one, which
/// is also how loops close.
///
/// It changes no graph itself: it says what is to be changed, and whoever holds the graph (such as
/// LandmarkMapper) says what became of that. After every keyframe comes `observe`, then `revise`
/// until it is empty; after the last one `conclude` until it is empty. Each contribution that is
/// not empty, and each of `observe`, is answered by `applied` or `refused` before the next one.
class LandmarkAssociation {
 public:
  /// Detections of sensors that `sensors` does not name are left aside; none named: all are used.
  /// Throws Error where the options have no extent.
  explicit LandmarkAssociation(const AssociationOptions& options = {}, ClassModel classes = {},
                               std::vector<std::string> sensors = {});

  /// Takes landmarks known before the first keyframe, which are in the map already, each under its
  /// id. Throws Error where their classes are not those of the options.
  void adopt(const KnownMap& known, bool is_3d);
  /// Log odds that a landmark is there, by id.
  std::map<std::int64_t, double> existence() const;
  /// What each landmark stands for, by id.
  std::map<std::int64_t, LandmarkSize> sizes(const MapView& map) const {
    return landmark_sizes(map, now_.classes, merges_.views(), options_, landmarks_);
  }

  /// Factors and variables for one keyframe. Throws Error where classes of a sensor are not known.
  Contribution observe(const KeyframeView& frame, const MapView& map);
  /// Takes note of what became of the last contribution.
  void applied(const Outcome& outcome);
  /// Nothing of the last contribution is in the graph, as it was not possible or, on trial, turned
  /// down: goes back to what was before it, to the bit, as if its keyframe had shown nothing. What
  /// is kept is that a merge was turned down, and that frames could not be left open: they are
  /// matched as is most probable.
  void refused();
  /// A change of what was contributed before: frames decided later, merges, loops.
  Contribution revise(const MapView& map);
  /// The same once no more keyframes come; then tentative landmarks go.
  Contribution conclude(const MapView& map);

  /// What became of every detection so far, in order, for evaluation.
  std::vector<AssociationDecision> decisions(const MapView& map) const {
    return hybrid::decisions(map, now_.open, movers_, landmarks_);
  }
  /// Things that move, which are no landmarks, at those of the `times` (in order, [s]) at which
  /// they were in sight.
  std::vector<Mover> movers(const std::vector<double>& times, const MapView& map) const {
    return movers_.movers(times, map, landmarks_);
  }
  /// Counts of what was done, by name.
  std::map<std::string, double> statistics() const;
  std::vector<std::string> class_names() const { return now_.classes.names(); }

 private:
  void take(const DetectionFrame& seen, const KeyframeView& frame, const MapView& map,
            Contribution& out);
  std::vector<int> note(const DetectionFrame& seen, Key pose,
                        const std::shared_ptr<const DetectionFrame>& sensor, bool is_3d,
                        Contribution& out);
  void take_best(const FrameHypothesis& best, const std::vector<int>& sightings,
                 const KeyframeView& frame, const MapView& map, Contribution& out);
  void keep_open(std::vector<FrameHypothesis> hypotheses, const std::vector<int>& sightings,
                 const KeyframeView& frame, const MapView& map, Contribution& out);
  void follow_decisions(const std::vector<OpenMatchings::Decided>& frames, const MapView& map,
                        Contribution& out);
  bool take_identified(int sighting, const KeyframeView& frame, const MapView& map,
                       Contribution& out);
  void learn_ids(const std::vector<int>& sightings);
  void attach(int sighting, int track, const MapView& map, Contribution& out);
  void create(int sighting, const Eigen::Isometry3d& T_map_robot, const MapView& map,
              Contribution& out);
  void discard(const std::vector<int>& tracks, const MapView& map, Contribution& out);
  void remember();
  Contribution next_revision(const MapView& map);
  Contribution next_conclusion(const MapView& map);
  Contribution answered_if_empty(Contribution out);
  Contribution try_out(const Merge& merge, const MapView& map);
  Contribution match_again(const MapView& map);

  /// What a contribution may change and does not grow with the map.
  struct Now {
    ClassModel classes;
    std::map<std::string, SensorCoverage> coverage;  // by label
    double density = 0;                              // of landmarks, per m^2 or m^3
    OpenMatchings open;
    int matched_again = 0;  // half-steps over all associations so far
    int keyframe = -1;
    int frames = 0;
    double sigmas = 0;           // of detections, as they are stated, their sum [m]
    std::size_t detections = 0;  // and their number
    std::map<std::string, double> statistics;
  };

  std::vector<std::string> sensors_;
  AssociationOptions options_;
  Now now_;
  std::optional<Now> before_;  // the last contribution, until it is answered
  LandmarkTracks landmarks_;
  MergeDecisions merges_;
  MovingThings movers_;
  bool adopted_ = false;  // landmarks of a map, whose ids of the log are learned by their places
  JournaledMap<std::int64_t, int> track_of_id_;  // of identified landmarks
};

}  // namespace hybrid
