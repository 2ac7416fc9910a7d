// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "libhybrid/association/consensus.h"
#include "libhybrid/core/journaled_map.h"
#include "libhybrid/landmarks/association_options.h"
#include "libhybrid/landmarks/landmark_tracks.h"
#include "libhybrid/landmarks/views.h"

namespace HYBRID_API hybrid {

/// Landmarks to be made one, the first of a pair into the second.
struct Merge {
  std::vector<std::pair<int, int>> pairs;
  double evidence = 0;    ///< log odds that the pairs are one, against no pair at all
  double chi_square = 0;  ///< of their differences, jointly
  /// What the fewer landmarks are worth: the objective may rise by less than this.
  double allowed_rise() const { return evidence + 0.5 * chi_square; }
  bool loop = false;  ///< of a place seen again, see LoopClosing
};

/// Finds landmarks that are one: those seen lately against all others that were never seen in one
/// frame with them, by consensus under their joint covariance. Only pairs that speak for
/// themselves count; see LoopClosing for those that several must agree about.
class LandmarkMerging {
 public:
  explicit LandmarkMerging(const AssociationOptions& options) : options_(options) {}

  /// Notes that a landmark was sighted at this keyframe, for the n-th time.
  void sighted(int track, int keyframe, std::size_t n);

  /// From here on what is sighted, and what `note` says, can be taken back.
  void remember();
  void take_back();

  /// The next merge that can be believed, or none. `density` is that of landmarks per m^2 or m^3.
  /// Unless of `everything`, it looks again only once enough is sighted, or it has found one.
  Merge propose(const MapView& map, const ClassModel& classes, double density, int keyframe,
                bool everything, const LandmarkTracks& landmarks) const;
  /// Notes whether there was one.
  void note(const Merge& proposed) { news_ = !proposed.pairs.empty(); }
  /// Forgets landmarks that are not recent any more.
  void forget(int keyframe);

  /// The same at the end of the log, with the misses as evidence: of two landmarks that are one,
  /// each look sees one at most. The best pair of landmarks, which may have been seen in one frame:
  /// then one of the sightings was clutter. Only of landmarks whose stretches of the way overlap:
  /// two of different stretches may only seem to be in one place, see LoopClosing. Landmarks that
  /// the sensor names, or that were known before, are not made others.
  Merge propose_by_misses(const MapView& map, const ClassModel& classes, double density,
                          const Views& views, const LandmarkTracks& landmarks) const;

  /// The same by counting, at all places at once: where single looks at landmarks that may be taken
  /// for each other show fewer things than they are, one is spared, the one whose sightings another
  /// explains best. What its classes say against that is taken off the evidence.
  Merge propose_by_counting(const MapView& map, const ClassModel& classes, const Views& views,
                            const LandmarkTracks& landmarks) const;

  /// A merge that raised the objective too much is not proposed again while nothing new is seen.
  void refuse(const Merge& merge, const LandmarkTracks& landmarks);

 private:
  struct Pair {
    int from, into;
    double distance;  // in sigmas, roughly
  };
  std::vector<Pair> possible_pairs(const MapView& map, const ClassModel& classes, double density,
                                   std::optional<int> since, bool together,
                                   const LandmarkTracks& landmarks) const;
  static IdentityHypotheses hypotheses_of(const std::vector<Pair>& pairs, const MapView& map,
                                          const ClassModel& classes, double density,
                                          const LandmarkTracks& landmarks);
  bool refused(int from, int into, const LandmarkTracks& landmarks) const;
  bool is_confirmed(int t, const LandmarkTracks& landmarks) const;
  bool may_become_another(int t, const LandmarkTracks& landmarks) const;
  std::vector<std::vector<int>> places(const MapView& map, const LandmarkTracks& landmarks) const;

  AssociationOptions options_;
  JournaledMap<int, int> recent_;  // track -> keyframe of its last sighting
  bool news_ = false, news_before_ = false;
  std::map<std::pair<int, int>, std::size_t> refused_;  // and the sightings of both then
};

}  // namespace hybrid
