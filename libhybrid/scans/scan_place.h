// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "libhybrid/scans/scan_closures.h"
#include "libhybrid/scans/scan_mapper.h"

namespace HYBRID_API hybrid {

struct ScanPlaceOptions {
  double query_length = 6.0;  ///< way whose scans are matched jointly [m]
  double every = 2.0;         ///< way between searches [m]
  double min_inliers = 0.5;   ///< share of the points on surfaces, of a match that counts
  int votes = 3;              ///< matches that agree, for a place
  double odds = 1e4;          ///< of a place to chance, and to every other place
  double view = 8.0;          ///< from the robot to points that are matched, at most [m]
  double reach = 8.0;         ///< half the width of what is searched around stored scans [m]
};

/// Searches for the place of a drive among stored scans, of which nothing is known but that it may
/// be there: stretches of the drive are matched with all of them at all headings, and places that
/// several stretches agree on are found, where no other place comes near.
class ScanPlaceSearch {
 public:
  /// A place of the frame of the drive, with what speaks for it.
  struct Place {
    UncertainMotion T_map_drive;
    SE2 stretch;             ///< in the frame of the drive: the last one that agrees
    int votes = 0;           ///< stretches that agree
    double log_odds = 0.0;   ///< to chance
    double last_vote = 0.0;  ///< way at which
    double last_odds = 0.0;  ///< that it counted for
  };

  explicit ScanPlaceSearch(std::vector<StoredScans> stored, const ScanPlaceOptions& options = {});

  /// Call it after every keyframe. The pose of the first keyframe in the frame of the stored scans,
  /// once it is found.
  std::optional<UncertainMotion> look(const ScanMapper& mapper);
  /// The same for a stretch by itself: its points in a frame that is at `stretch` in that of the
  /// drive. `way` is a number that no other stretch has.
  const Place* look(const std::vector<SurfacePoint>& points, const SE2& stretch, double way);

  /// All places so far, the one for which most speaks first.
  std::vector<Place> places() const;

 private:
  void vote(const UncertainMotion& T_map_drive, const SE2& stretch, double way, double log_odds);
  const Place* best() const;
  std::shared_ptr<const MatchTarget> surroundings(const StoredScans& scans) const;

  ScanPlaceOptions options_;
  std::vector<StoredScans> stored_;
  std::vector<std::shared_ptr<const MatchTarget>> targets_;
  std::vector<Place> places_;
  double next_ = 0.0;
};

}  // namespace hybrid
