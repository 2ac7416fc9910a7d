// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "libhybrid/scans/place_tiles.h"
#include "libhybrid/scans/scan_mapper.h"

namespace HYBRID_API hybrid {

struct ScanPlaceOptions {
  double query_length = 6.0;  ///< way whose scans are matched jointly [m]
  double every = 3.0;         ///< way between searches [m]
  double min_inliers = 0.5;   ///< share of the points on surfaces, of a match that counts
  int votes = 2;              ///< places that must agree: a room may look like another
  double apart = 8.0;         ///< between these, more than a room [m]
  double odds = 1e4;          ///< of a place to chance, and to every other place
};

/// Searches for the place of a drive among stored scans, of which nothing is known but that it may
/// be there. Stretches of the drive are matched with all of them at all headings, and followed from
/// there. How well a wrong place fits is measured: by the mirror image of each stretch, which
/// exists nowhere.
class ScanPlaceSearch {
 public:
  /// A place of the frame of the drive, with what speaks for it.
  struct Place {
    UncertainMotion T_map_drive;
    SE2 stretch;  ///< in the frame of the drive: the last one that agrees
    std::vector<Eigen::Vector2d> seen_from;  ///< where stretches agree, `apart`, in the map
    double fit = 0.0;       ///< what speaks for it, to be compared with that of other places
    double log_odds = 0.0;  ///< to chance
  };

  explicit ScanPlaceSearch(std::vector<StoredScans> stored, const ScanPlaceOptions& options = {});

  /// Call it after every keyframe. The pose of the first keyframe in the frame of the stored scans,
  /// once it is found.
  std::optional<UncertainMotion> look(const ScanMapper& mapper);
  /// The same for a stretch by itself: its points in a frame that is at `stretch` in that of the
  /// drive.
  const Place* look(const std::vector<SurfacePoint>& points, const SE2& stretch);

  /// All places so far, the one for which most speaks first.
  const std::vector<Place>& places() const { return places_; }

 private:
  double share_by_chance(const std::vector<SurfacePoint>& points, const SE2& stretch,
                         const std::vector<MatchMode>& found);
  std::vector<SurfacePoint> fresh_of(const std::vector<SurfacePoint>& points, const SE2& stretch);
  void follow(const std::vector<SurfacePoint>& points, const SE2& stretch);
  void count(const std::vector<SurfacePoint>& points, const ScanAlignment& found,
             const SE2& stretch, double by_chance, Place& at);
  void forget_weak();
  bool stands_out() const;
  UncertainMotion with_map(const SE2& pose, const Eigen::Matrix3d& covariance) const;

  ScanPlaceOptions options_;
  PlaceTiles tiles_;
  std::vector<Place> places_;
  std::set<std::pair<int, int>> seen_;  // metres of the frame of the drive that have counted
  double next_ = 0.0;
};

}  // namespace hybrid
