// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "libhybrid/core/key.h"
#include "libhybrid/factors/surface_match.h"
#include "libhybrid/geometry/known_place.h"
#include "libhybrid/online/known_places.h"
#include "libhybrid/online/online_selection.h"

namespace HYBRID_API hybrid {

/// A relative pose between poses of different times, which may be false.
template <class Pose>
struct PlaceClosure {
  std::size_t from = 0;        ///< pose, or a known place
  std::size_t to = 0;          ///< pose
  Uncertain<Pose> pose;        ///< of `to` in the frame of `from`
  double inliers = 0;          ///< share of the points that lie on a surface
  int modes = 1;               ///< that the same search has found, of which at most one is true
  std::size_t first_mode = 0;  ///< number of the first of them, of all found for the pose
  bool is_known = false;       ///< `from` counts the known places
};

/// A path of poses, the motions between them, and closures, of which any may be false: with each
/// other (see OnlineSelection), and with known places of an earlier map.
template <class Pose>
class ClosureGraph {
 public:
  explicit ClosureGraph(const OnlineSelectionOptions& options) : selection_(options) {}

  /// Before the first pose: where that is in the frame of known places, and these.
  void adopt(std::vector<KnownPlace<Pose>> places, const Uncertain<Pose>& start);
  /// Adds the first pose.
  void begin();
  /// A motion from pose `from` to a new one.
  struct Motion {
    std::size_t from = 0;
    Uncertain<Pose> measured;
  };
  /// The change that adds the next pose, at `initial`.
  Delta step(std::size_t next, const Pose& initial, const std::vector<Motion>& motions) const;
  /// Applies a change, with the closures that were found, all to one pose. If it throws, nothing
  /// has changed.
  void add(Delta change, const std::vector<PlaceClosure<Pose>>& found);
  /// Decides all closures again and solves to convergence.
  void finish() { selection_.finish(); }

  Pose pose(std::size_t i) const;
  /// Where pose b is, seen from pose a.
  Uncertain<Pose> relation(std::size_t a, std::size_t b) const;
  /// Where a pose is, seen from a known place; while the graph holds none of those beside which
  /// this is known, as if the errors of both were independent.
  Uncertain<Pose> from_place(std::size_t place, std::size_t pose) const;
  const std::vector<KnownPlace<Pose>>& places() const { return places_; }
  const std::vector<PlaceClosure<Pose>>& closures() const { return closures_; }
  const OnlineSelection& selection() const { return selection_; }

 private:
  typename SurfaceMatch<Pose>::Spread spread(std::size_t poses) const;

  OnlineSelection selection_;
  std::vector<KnownPlace<Pose>> places_;
  Uncertain<Pose> start_{Pose(), kOrigin* kOrigin* Pose::Jacobian::Identity()};
  std::vector<PlaceClosure<Pose>> closures_;

  static constexpr double kOrigin = 1e-3;  // m, rad: sigma of a first pose that is the frame
};

extern template class ClosureGraph<SE2>;
extern template class ClosureGraph<SE3>;

}  // namespace hybrid
