// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <iterator>
#include <optional>
#include <vector>

#include "libhybrid/landmarks/contribution.h"
#include "libhybrid/online/closure_graph.h"
#include "libhybrid/online/join_graph.h"
#include "mrpt_plugins/mapping/map_result.h"

namespace HYBRID_API hybrid {

/// Where pose b of a map is, seen from pose a; a default covariance where the map does not tell it
/// before it is solved.
template <class Pose>
Uncertain<Pose> relation_in(const MapView& map, Key a, Key b);

/// Closures between robots at the end of their logs, by what they saw of the same places; returns
/// their number. `robots` of a plugin have a `mapper`, and the `keys` of its poses; `places` tells
/// what one saw by its local maps, in the frame of its first pose; `factor` makes that of a motion.
template <class Pose, class Robots, class Places, class Factor>
std::size_t tie_robots(const Robots& robots, const MapView& map, const Places& places,
                       const Factor& factor, Contribution& out) {
  std::size_t count = 0;
  if (robots.size() < 2) return count;
  const auto is_in_map = [&](const auto& robot) {
    return !robot.keys.empty() && map.holds(robot.keys.front());
  };
  const auto anchor = [](const auto& robot, std::size_t place) {
    return robot.keys[robot.mapper.tracker().local_maps()[place].anchor];
  };
  for (auto a = robots.begin(); a != robots.end(); ++a) {
    if (!is_in_map(a->second)) continue;
    const auto seen = places(a->second);
    for (auto b = std::next(a); b != robots.end(); ++b) {
      if (!is_in_map(b->second)) continue;
      const auto known = relation_in<Pose>(map, a->second.keys.front(), b->second.keys.front());
      for (const PlaceMatch<Pose>& match : common_places(seen, places(b->second), known)) {
        const Key from = anchor(a->second, match.first), to = anchor(b->second, match.second);
        if (!map.holds(from) || !map.holds(to)) continue;
        out.delta.continuous.push_back(factor(from, to, match.pose));
        out.settle = true;
        ++count;
      }
    }
  }
  return count;
}

/// Closures so far of the robots of a plugin, which have `factors`, too, between keyframes of the
/// map, with the present decisions.
template <class Pose, class Robots>
std::vector<MeasuredClosure<Pose>> measured_closures(const Robots& robots) {
  std::vector<MeasuredClosure<Pose>> out;
  for (const auto& [number, robot] : robots) {
    std::vector<ClosureDecision> decisions = robot.mapper.decisions();
    for (std::size_t k = 0; k < decisions.size(); ++k) {
      const PlaceClosure<Pose>& closure = robot.mapper.closures()[k];
      if (closure.is_known) continue;
      if (decisions[k].accepted() && !robot.factors.has(k)) {
        decisions[k].status = ClosureStatus::kUndecided;
      }
      out.push_back({{static_cast<std::size_t>(robot.keys[closure.from].index()),
                      static_cast<std::size_t>(robot.keys[closure.to].index()), decisions[k],
                      closure.inliers, closure.modes},
                     closure.pose.motion});
    }
  }
  return out;
}

/// Closures of a robot that its mapper has accepted since the last time come in, where the map has
/// their keyframes; those that it no longer accepts go out. `newest`: the keyframe that comes with
/// the contribution, if one does.
template <class Robot, class Factor>
void follow_closures(Robot& robot, std::optional<Key> newest, const MapView& map,
                     const Factor& factor, Contribution& out) {
  std::vector<bool> accepted(robot.mapper.closures().size());
  for (std::size_t k = 0; k < accepted.size(); ++k) {
    accepted[k] = robot.mapper.status(k) == ClosureStatus::kAccepted;
  }
  const auto add = [&](std::size_t k, Contribution& to) {
    const auto& closure = robot.mapper.closures()[k];
    const Key later = robot.keys[closure.to];
    if (later != newest && !map.holds(later)) return false;
    Key from = place_key(closure.from);
    if (closure.is_known) {
      const auto& places = robot.mapper.places();
      if (map.is_3d != (places[closure.from].motion.kDim == SE3::kDim)) return false;
      insert_place(places, closure.from, map.values, to.delta);
    } else {
      from = robot.keys[closure.from];
      if (!map.holds(from)) return false;
    }
    to.delta.continuous.push_back(factor(from, later, closure.pose));
    return true;
  };
  robot.factors.follow(accepted, add, map.keeps_all, out);
}

/// Which closures of a front end, which decides about them by itself, are factors of the map: those
/// that it accepts come in, those that it no longer accepts go out, each once the map has taken the
/// contribution.
class ClosureFactors {
 public:
  /// Adds the factor of a closure to a contribution, last of its continuous factors; false where
  /// the map has no room for it.
  using Add = std::function<bool(std::size_t closure, Contribution& out)>;

  /// `accepted`: by closure, all so far. Factors leave only where `may_leave`.
  void follow(const std::vector<bool>& accepted, const Add& add, bool may_leave, Contribution& out);
  /// The contribution is in the map.
  void applied(const Outcome& outcome);
  /// It is not.
  void forget();
  bool has(std::size_t closure) const {
    return closure < handles_.size() && handles_[closure].has_value();
  }

 private:
  struct Asked {
    std::size_t closure = 0;
    std::size_t factor = 0;  // number of that in the contribution
  };
  std::vector<std::optional<Handle>> handles_;  // by closure
  std::vector<Asked> coming_;
  std::vector<std::size_t> leaving_;
};

}  // namespace hybrid
