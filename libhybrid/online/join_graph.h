// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include "libhybrid/geometry/known_place.h"
#include "libhybrid/online/online_selection.h"

namespace HYBRID_API hybrid {

/// A stretch of a map, in the frame of its first pose, the anchor.
template <class Pose>
struct StoredPlace {
  KnownPlace<Pose> T_map_anchor;
  typename Pose::Point middle = Pose::Point::Zero();  ///< of what was seen, in that frame
  bool is_empty = false;                              ///< nothing was seen
};

/// The anchor of the place of a second map, in the frame of that, which is nearest to any of a
/// first one.
template <class Pose>
typename Pose::Point nearest_anchor(const std::vector<StoredPlace<Pose>>& first,
                                    const std::vector<StoredPlace<Pose>>& second,
                                    const Pose& T_first_second);

/// Where a place of one map is in a place of another, by a match.
template <class Pose>
struct PlaceMatch {
  std::size_t first = 0, second = 0;
  Uncertain<Pose> pose;  ///< of the second in the frame of the first
};

/// Places of two maps, the motion between these, and matches of places of both, some of which may
/// be false. Errors of places that are known beside no other count as independent.
template <class Pose>
class JoinGraph {
 public:
  /// Matches that must agree with each other, for two maps to be joined.
  static constexpr std::size_t kLeastMatches = 3;
  /// Stretches of a map that are searched in the other, at most.
  static constexpr std::size_t kMostStretches = 60;

  /// All poses of place k of the second map in place i of the first that a search finds, where the
  /// predicted one says.
  using Match = std::function<std::vector<Uncertain<Pose>>(std::size_t i, std::size_t k,
                                                           const Uncertain<Pose>& predicted)>;
  struct Options {
    double view = 0;    ///< distance of middles beyond which places are not matched [m]
    int most_maps = 4;  ///< places of the first map that one of the second is matched with, at most
  };

  /// The second map is in the first at `motion`, as known at the place `where` of the second:
  /// places near that are matched first.
  JoinGraph(std::vector<StoredPlace<Pose>> first, std::vector<StoredPlace<Pose>> second,
            const Uncertain<Pose>& motion, const typename Pose::Point& where, const Match& match,
            const Options& options);

  std::size_t matches() const { return matches_.size(); }
  std::vector<PlaceMatch<Pose>> accepted() const;
  /// Of the frame of the second map in that of the first.
  Uncertain<Pose> motion() const;
  /// Anchors of the places of both in the frame of the first map, those of its own first. Places of
  /// the second that are known beside no other are so beside one of the first.
  std::vector<KnownPlace<Pose>> anchors() const;

 private:
  Uncertain<Pose> estimate(Key key) const;
  bool holds(Key key) const { return selection_.smoother().values().contains(key); }
  void insert(Key key, const Pose& pose, ContinuousFactorPtr factor);
  std::vector<std::size_t> near(std::size_t k, const Options& options) const;
  Uncertain<Pose> relation(std::size_t i, std::size_t k) const;
  void insert_first(std::size_t i);
  void insert_second(std::size_t k);
  void add(std::size_t k, const Match& match, const Options& options);

  std::vector<StoredPlace<Pose>> first_, second_;
  std::vector<KnownPlace<Pose>> first_anchors_, second_anchors_;
  OnlineSelection selection_;
  std::vector<PlaceMatch<Pose>> matches_;  // as the selection counts them
};

extern template class JoinGraph<SE2>;
extern template class JoinGraph<SE3>;

}  // namespace hybrid
