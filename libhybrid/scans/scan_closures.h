// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "libhybrid/geometry/known_place.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/online/place_search.h"
#include "libhybrid/scans/scan_match.h"
#include "libhybrid/scans/scan_tracker.h"

namespace HYBRID_API hybrid {

struct ScanClosureOptions {
  double every = 0.5;         ///< way between searches [m]
  double query_length = 4.0;  ///< way whose scans are matched jointly [m]
  double view = 4.0;          ///< distance at which places share surfaces [m]
  int most_maps = 4;          ///< local maps searched for one keyframe, at most
  double max_reach = 8.0;     ///< half the width of the window of a search, at most [m]
  double max_turn = 3.2;      ///< and of its angle: any [rad]
  MatchOptions match;
};

/// What scans saw along a stretch of an earlier drive, in the frame of its first keyframe.
struct StoredScans {
  KnownPlace<SE2> T_map_anchor;
  std::vector<SurfacePoint> points;
};

/// A relative pose between keyframes of different times, or of stored scans and a keyframe.
using ScanClosure = PlaceClosure<SE2>;

/// Searches for places that the robot has seen before: the scans of the last metres are matched
/// jointly with earlier local maps that may be near.
class ScanClosureSearch {
 public:
  /// Estimate of the pose of a keyframe.
  using Poses = std::function<SE2(std::size_t keyframe)>;
  /// Estimate of the pose of keyframe b in the frame of a.
  using Relation = std::function<UncertainMotion(std::size_t a, std::size_t b)>;

  explicit ScanClosureSearch(const ScanClosureOptions& options = {});

  /// Scans of earlier drives to search, too, in the frame of the estimates.
  void store(std::vector<StoredScans> scans) { stored_ = std::move(scans); }
  const std::vector<StoredScans>& stored() const { return stored_; }
  /// The way at which it searches again [m].
  double next() const { return next_; }
  void go_back_to(double next) { next_ = next; }

  /// Candidates of the newest keyframe, all modes of each; none while the way since the last search
  /// is short. `stored` tells the pose of a keyframe b in the frame of the stored scans a.
  std::vector<ScanClosure> search(const ScanTracker& tracker, const Poses& poses,
                                  const Relation& relation, const Relation& stored = {});

 private:
  /// Distances from a place [m], and numbers, the nearest first.
  using Near = std::vector<std::pair<double, std::size_t>>;
  /// The last metres of the way, which are matched jointly.
  struct Stretch : PathEnd<SE2> {
    std::vector<SurfacePoint> points;  ///< in the frame of the last keyframe
  };
  Near stored_near(const Eigen::Vector2d& here) const;
  const MatchTarget& target(const ScanTracker& tracker, const PlaceName& name);
  Stretch present_stretch(const ScanTracker& tracker, const Relation& relation) const;
  bool look(const ScanTracker& tracker, const PlaceName& name, double distance,
            const Relation& relation, const Stretch& stretch, std::vector<ScanClosure>& closures);

  ScanClosureOptions options_;
  double next_ = 0.0;  // way at which to search again
  KeptTargets<MatchTarget> targets_;
  std::vector<StoredScans> stored_;
};

/// The window that covers where something may be, as predicted.
SearchWindow window_of(const UncertainMotion& predicted, const ScanClosureOptions& options);

/// Points of the last metres of a way, ten centimetres apart, in the frame of the last keyframe.
std::vector<SurfacePoint> recent_points(const ScanTracker& tracker, double length);

/// What the scans of a stretch saw, in the frame of its first keyframe.
struct LocalScans {
  std::size_t anchor = 0;            ///< keyframe
  std::vector<SurfacePoint> points;  ///< ten centimetres apart
};

/// Those of all local maps, to be stored.
std::vector<LocalScans> local_scans(const ScanTracker& tracker);

}  // namespace hybrid
