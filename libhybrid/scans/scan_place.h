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
  double map_length = 8.0;    ///< way that stored scans span [m]
  double min_inliers = 0.5;   ///< share of the points on surfaces, of a match that counts
  /// Stretches that must agree on a place, so far apart that they share no way: a room may look
  /// like another.
  int votes = 2;
  double odds = 1e4;  ///< of a place to chance, and to every other place
  /// Where the first pose of the drive is in the map, if that is roughly known. Then the drive is
  /// in the map: only places that agree with it are followed, one stretch is enough, and the odds
  /// are to the other ones of these.
  std::optional<UncertainMotion> start = std::nullopt;
};

/// A place of the frame of a drive, with what speaks for it.
struct ScanPlace {
  UncertainMotion T_map_drive;
  SE2 stretch;                             ///< in the frame of the drive: the last one that agrees
  std::vector<Eigen::Vector2d> seen_from;  ///< where stretches that share no way agree, in the map
  double on = 0.0, off = 0.0;  ///< lengths of surfaces that are on those of the map, and not [m]
  double fit = 0.0;            ///< what speaks for it, to be compared with that of other places
};

/// Places among stored scans where stretches of a drive fit, followed along the drive.
class FollowedPlaces {
 public:
  explicit FollowedPlaces(const ScanPlaceOptions& options) : options_(options) {}

  /// Follows the places so far, and adds those where a stretch fits: its points, in a frame that is
  /// at `stretch` in that of the drive.
  void look(PlaceTiles& tiles, const std::vector<SurfacePoint>& points, const SE2& stretch);

  /// The one for which most speaks first.
  const std::vector<ScanPlace>& places() const { return places_; }

 private:
  std::vector<SurfacePoint> fresh_of(const std::vector<SurfacePoint>& points, const SE2& stretch);
  void count(PlaceTiles& tiles, const ScanAlignment& found, const std::vector<SurfacePoint>& fresh,
             const SE2& stretch, ScanPlace& at) const;
  void forget_weak();

  ScanPlaceOptions options_;
  std::vector<ScanPlace> places_;
  std::set<std::pair<int, int>> seen_;  // cells of the frame of the drive that have counted
};

/// Searches for the place of a drive among stored scans, of which nothing is known but that it may
/// be there. Stretches of the drive are matched with all of them at all headings, and followed from
/// there. How well a wrong place fits is measured: by the mirror image of the drive, which is
/// nowhere.
class ScanPlaceSearch {
 public:
  explicit ScanPlaceSearch(std::vector<StoredScans> stored, const ScanPlaceOptions& options = {});

  /// Call it after every keyframe. The pose of the first keyframe in the frame of the stored scans,
  /// once it is found.
  std::optional<UncertainMotion> look(const ScanMapper& mapper);
  /// The same for a stretch by itself: its points in a frame that is at `stretch` in that of the
  /// drive. Null where no place stands out yet.
  const ScanPlace* look(const std::vector<SurfacePoint>& points, const SE2& stretch);

  /// Whether it is time for a look, after this way [m]; the next one then is later.
  bool is_due(double way);

  /// All places so far, the one for which most speaks first.
  const std::vector<ScanPlace>& places() const { return drive_.places(); }

  /// Of the first place to every other, and to the best that the mirrored drive ever had.
  double log_odds() const;

 private:
  bool stands_out() const;

  ScanPlaceOptions options_;
  PlaceTiles tiles_;
  FollowedPlaces drive_, mirrored_;
  double by_chance_ = 0.0;  // the best fit of the mirrored drive so far
  double next_ = 0.0;
};

}  // namespace hybrid
