// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "libhybrid/landmarks/frame_association.h"

namespace HYBRID_API hybrid {

/// Frames whose matching is not decided. Each is a discrete variable of the graph with a value for
/// each hypothesis (eq. 18), until somebody asks what it has come to.
class OpenMatchings {
 public:
  /// What a frame was decided to be.
  struct Decided {
    bool is_revised = false;                  ///< not what was the best at first
    std::vector<std::pair<int, int>> tracks;  ///< of its open sightings; -1: of no landmark
  };

  /// A frame with several hypotheses, before it is opened.
  struct Kept {
    std::vector<FrameHypothesis> hypotheses;
    std::vector<std::size_t> rows;  ///< of the detections that they disagree about
    std::vector<int> sightings;     ///< of these
  };

  /// By detection, whether hypotheses of its frame, of which there is one at least, disagree.
  static std::vector<bool> disputed(const std::vector<FrameHypothesis>& hypotheses);
  /// Keeps a frame until it is opened: before the map has come to terms with the best hypothesis,
  /// the first, distances mean little.
  void keep(std::vector<FrameHypothesis> hypotheses, const std::vector<int>& sightings,
            LandmarkTracks& landmarks);
  /// Hands out the frames that are kept, to be opened.
  std::vector<Kept> take_kept() { return std::exchange(kept_, {}); }
  /// Opens a frame, so that its sightings have the factors of all hypotheses.
  void open(const Kept& frame, int keyframe, const MapView& map, LandmarkTracks& landmarks,
            Contribution& out);
  bool empty() const { return open_.empty(); }

  /// Decides the frames that were opened at this keyframe or before, by their variables.
  std::vector<Decided> decide_until(int keyframe, const MapView& map, LandmarkTracks& landmarks);
  /// Decides those that may be of a landmark of one of these pairs.
  std::vector<Decided> decide_about(const std::vector<std::pair<int, int>>& pairs,
                                    const MapView& map, LandmarkTracks& landmarks);

  /// The sightings of open frames.
  std::set<int> sightings() const;
  /// The same, and the tracks that their variables give them now.
  std::map<int, int> tracks(const MapView& map) const;
  /// Counts anew of each track the hypotheses that hold it.
  void count(LandmarkTracks& landmarks) const;

 private:
  struct Open {
    int keyframe;
    DiscreteKey choice;
    std::vector<int> sightings;            // the undecided ones
    std::vector<std::vector<int>> tracks;  // by value of the choice, of these
  };

  template <class IsAsked>
  std::vector<Decided> decide(const IsAsked& is_asked, const MapView& map,
                              LandmarkTracks& landmarks);

  std::vector<Kept> kept_;
  std::vector<Open> open_;
  int opened_ = 0;
};

}  // namespace hybrid
