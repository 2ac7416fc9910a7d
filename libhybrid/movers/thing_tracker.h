// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "libhybrid/movers/mover.h"
#include "libhybrid/movers/point_sighting.h"

namespace HYBRID_API hybrid {

/// A numbered sighting for the tracker.
struct ThingSighting {
  int number = 0;                  ///< not negative, rising
  PointSighting seen;              ///< as the newest pose is expected, its uncertainty included
  std::optional<std::int64_t> id;  ///< of the thing, if the sensor identifies it
  std::vector<double> phi;         ///< likelihood of each class; empty if not classified
};

/// Follows all that is seen, whether it stands or moves, from frame to frame, and says of each
/// thing by the evidence of its sightings which of the two it does. It knows neither poses nor
/// landmarks: `locate` gives a former sighting at the present estimate of the map.
class ThingTracker {
 public:
  using Locate = std::function<PointSighting(int number)>;

  explicit ThingTracker(MotionPrior prior = {}) : prior_(std::move(prior)) {}

  /// Whether anything can move at all; if not, nothing needs to be followed.
  bool is_on() const;
  /// What a frame of sightings is compared with.
  struct Look {
    double detected = 0.5;  ///< probability that a thing in view is detected
    double space = 1;       ///< that the sensor overlooks [m^2 or m^3]
    bool is_3d = false;
    std::vector<double> class_prior;  ///< empty without classes
  };
  /// Takes in the sightings of a frame: each continues at most one thing or is the first of a new
  /// one.
  void take(const std::vector<ThingSighting>& frame, const Look& look, const Locate& locate);
  /// From here on frames that are taken in can be taken back, up to the next decision about all
  /// things and while nobody asks what has changed.
  void remember() { before_.emplace(); }
  void take_back();
  /// Decides anew about all things, by all their sightings at the present estimate.
  void decide(const Locate& locate);

  /// Whether the thing of a sighting moves.
  bool moves(int number) const;
  /// Sightings of the things that were decided otherwise since the last call.
  std::vector<int> take_changed();
  /// All things that move, at those of the `times` at which they were in sight.
  std::vector<Mover> movers(const std::vector<double>& times, const Locate& locate) const;
  /// The id of the mover that a sighting is of.
  std::optional<std::int64_t> mover_of(int number) const;

 private:
  struct Thing {
    std::vector<int> sightings;
    std::optional<std::int64_t> id;
    std::vector<double> class_evidence;  // log p(scores | class)
    double log_odds = 0;                 // that it moves
    int missed = 0;                      // frames since it was seen
    bool moves = false;
  };

  /// What a frame may change: how many things, sightings and changes there were, and the things
  /// that were followed, with the number of their sightings in place of these.
  struct Before {
    std::size_t things = 0, sightings = 0, changed = 0;
    std::vector<int> followed;
    std::vector<std::pair<std::size_t, Thing>> states;  // of `followed`
    double born = 1, frames = 0;
    Look look;
  };

  Before before() const;
  template <int D>
  void take_in(const std::vector<ThingSighting>& frame, const Locate& locate);
  void add(int thing, const ThingSighting& sighting);
  void settle(int thing, double evidence);
  std::vector<double> class_belief(const Thing& thing) const;
  double share_moving(const std::vector<double>& belief) const;
  double births() const;

  MotionPrior prior_;
  Look look_;  // the last one
  std::vector<Thing> things_;
  std::vector<int> followed_;  // things that may be seen again
  std::vector<int> thing_of_;  // by sighting; -1: of none
  std::vector<int> changed_;   // things decided otherwise
  double born_ = 1;            // things first seen after the first frame, and one more
  double frames_ = 0;
  std::optional<std::vector<Before>> before_;  // each frame since told to remember
};

}  // namespace hybrid
