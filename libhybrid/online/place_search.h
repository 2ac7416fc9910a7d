// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "libhybrid/online/closure_graph.h"

namespace HYBRID_API hybrid {

/// A local map of this drive, or a known place, by its number.
struct PlaceName {
  bool is_known = false;
  std::size_t number = 0;
  bool operator<(const PlaceName& b) const {
    return std::make_pair(is_known, number) < std::make_pair(b.is_known, b.number);
  }
};

/// What places are matched with: made when first needed, and kept as long as it is among those used
/// last.
template <class Target>
class KeptTargets {
 public:
  explicit KeptTargets(std::size_t most) : most_(most) {}

  /// `make` returns one that is not kept. It stays until the next call.
  template <class Make>
  const Target& at(const PlaceName& name, const Make& make) {
    auto found = targets_.find(name);
    if (found == targets_.end()) found = targets_.emplace(name, Kept{make(), 0}).first;
    found->second.used = ++uses_;
    if (targets_.size() > most_) {
      targets_.erase(std::min_element(
          targets_.begin(), targets_.end(),
          [](const auto& a, const auto& b) { return a.second.used < b.second.used; }));
    }
    return found->second.target;
  }

 private:
  struct Kept {
    Target target;
    std::size_t used = 0;  // the use that was the last
  };
  std::size_t most_;
  std::map<PlaceName, Kept> targets_;
  std::size_t uses_ = 0;
};

/// How the end of a path, what was seen along which is matched jointly, is known beside a match.
template <class Pose>
struct PathEnd {
  double way = 0;     ///< along it [m]
  double shared = 1;  ///< number of searches that share what was seen
  typename Pose::Jacobian walk = Pose::Jacobian::Zero();  ///< covariance of the motion along it

  /// The covariance of a match. The places of a stretch walk at random relative to its end, and so
  /// does their mean, by a third of that; the same holds for the map around the pose to which a
  /// closure refers, or `from_anchor` [m], from the anchor of a known place to the pose. Searches
  /// that share points tell a share each.
  typename Pose::Jacobian widened(const typename Pose::Jacobian& match, double from_anchor) const {
    const double steps = 2.0 / 3.0 + (way > 0 ? from_anchor / way : 0.0);
    return shared * (match + steps * walk);
  }
};

/// Local maps, which have an `anchor` and the `poses` from there on, that were left behind, by
/// their distances from a place where these are within a limit [m]; the nearest first.
template <class Map, class Poses, class Point>
std::vector<std::pair<double, std::size_t>> maps_near(const std::vector<Map>& maps,
                                                      const Poses& poses, const Point& here,
                                                      double limit) {
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t m = 0; m + 1 < maps.size(); ++m) {
    const Map& map = maps[m];
    if (map.anchor + map.poses.size() > maps.back().anchor) continue;
    const auto anchor = poses(map.anchor);
    double nearest = std::numeric_limits<double>::infinity();
    for (const auto& pose : map.poses) {
      nearest = std::min(nearest, (anchor * pose.translation() - here).norm());
    }
    if (nearest < limit) near.emplace_back(nearest, m);
  }
  std::stable_sort(near.begin(), near.end());
  return near;
}

/// Whether a local map overlaps any of others: the one before and the one behind it do.
inline bool overlaps(const std::vector<std::size_t>& others, std::size_t map) {
  return std::any_of(others.begin(), others.end(),
                     [&](std::size_t other) { return other + 1 == map || map + 1 == other; });
}

/// Makes a closure with a local map, from its anchor, one with its pose nearest to where the
/// closure leads: what lies between that and the anchor is not known as well as the match is.
template <class Map, class Pose>
void refer_to_nearest(const Map& map, PlaceClosure<Pose>& closure) {
  const auto distance = [&](const Pose& pose) {
    return (pose.translation() - closure.pose.motion.translation()).norm();
  };
  const auto nearest =
      std::min_element(map.poses.begin(), map.poses.end(),
                       [&](const Pose& a, const Pose& b) { return distance(a) < distance(b); });
  closure.from = map.anchor + static_cast<std::size_t>(nearest - map.poses.begin());
  closure.pose.motion = nearest->between(closure.pose.motion);
}

}  // namespace hybrid
