// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "libhybrid/association/constellation.h"
#include "libhybrid/geometry/eigen.h"
#include "libhybrid/maps/place_map.h"

namespace HYBRID_API hybrid {

/// A place found.
template <class Pose>
struct FoundPlace {
  Pose T_map_here;
  /// Of it, given the map near by, in the tangent of a right perturbation.
  typename Pose::Jacobian covariance;
  std::vector<std::pair<int, int>> pairs;  ///< of `here` and of the map
  double log_odds = 0;                     ///< for this place against none
};

/// The one place of the map that the landmarks speak for. Every two landmarks (three in space) that
/// are as far apart as others of the map put `here` into it; the most promising of these places are
/// matched and weighed by match_places, with a prior that is uniform over the map and all headings.
/// At least `dim` + 1 landmarks must agree.
///
/// Landmarks are not strewn at random, so that chance reaches more than their evidence says: rows
/// of parked cars fit many streets. How much is measured by what cannot be in the map: the mirror
/// images of each `here` and of pieces of the map of as many landmarks, which have the same
/// distances and stand in as many rows, where they are found elsewhere than the originals.
class HYBRID_API PlaceSearch {
 public:
  /// `odds` is the evidence needed against any other place, and against none beyond what chance has
  /// reached so far.
  explicit PlaceSearch(double odds) : margin_(std::log(odds)) {}

  template <class Pose>
  std::optional<FoundPlace<Pose>> find(const PlaceQuestion<Pose>& question);

  /// Whether a place still stands out from what chance has reached by now.
  bool stands_out(double log_odds) const { return log_odds >= margin_ + chance_; }

 private:
  template <class Pose>
  double chance_of_pieces(const PlaceQuestion<Pose>& question);

  double margin_;
  double chance_ = 0;  // log odds that mirror images of `here` reached, at most
  std::map<std::size_t, double> chance_of_pieces_;  // by the number of their landmarks
};

/// The class of two landmarks as evidence that they are one: log sum p q / prior.
HYBRID_API double same_class_log_likelihood_ratio(const std::vector<double>& p,
                                                  const std::vector<double>& q,
                                                  const std::vector<double>& prior);

}  // namespace hybrid
