// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libhybrid/clouds/cloud_mapper.h"
#include "libhybrid/scans/scan_place.h"

namespace HYBRID_API hybrid {

struct CloudPlaceOptions {
  double odds = 1e4;  ///< of a place to chance, and to every other place
  /// Where the first pose of the drive is in the map, if that is roughly known.
  std::optional<UncertainMotion3> start = std::nullopt;
};

/// Of stored clouds [m]; 1 where there are none.
double widest_spacing(const std::vector<StoredCloud>& stored);

/// How far a look for a place sees among clouds of a spacing [m].
double view_of(double spacing);

/// Searches for the place of a drive among stored clouds, of which nothing is known but that it may
/// be there. Walls and poles, seen from above, are searched as those of planar scans are, in units
/// in which the spacing of the clouds is that of scans; where a place stands out, the surfaces in
/// space tell the height, and whether it is one. Floors and ceilings tell the vertical of both, of
/// which the z axes are within half a radian.
class CloudPlaceSearch {
 public:
  explicit CloudPlaceSearch(std::vector<StoredCloud> stored, const CloudPlaceOptions& options = {});

  /// Call it after every cloud. The pose of the first cloud in the frame of the stored ones, once
  /// it is found.
  std::optional<UncertainMotion3> look(const CloudMapper& mapper);
  /// The same for a stretch by itself: its points in a frame that is at `stretch` in that of the
  /// drive. The frame of the drive in that of the stored clouds.
  std::optional<UncertainMotion3> look(const std::vector<CloudPoint>& points, const SE3& stretch);

  /// What speaks against the best place, if none was found.
  const std::string& doubt() const { return doubt_; }
  double log_odds() const { return plan_.log_odds(); }  ///< of the place in the plane
  double view() const { return view_of(spacing_); }

 private:
  std::vector<double> heights_near(const Eigen::Vector2d& place) const;
  CloudSurfaces surfaces_near(const Eigen::Vector2d& place) const;
  std::vector<CloudAlignment> poses_at(const std::vector<CloudPoint>& points,
                                       const Eigen::Matrix3d& level, const SE2& place) const;
  UncertainMotion3 in_map(const CloudAlignment& found) const;
  bool is_allowed(const SE3& T_map_drive) const;

  CloudPlaceOptions options_;
  SE3 T_level_map_;
  std::optional<SE3> T_level_drive_;      // once it is known
  std::vector<StoredCloud> stored_;       // in the level frame
  std::vector<Eigen::Vector3d> middles_;  // of what each shows, in the same
  double spacing_ = 1, scale_ = 1;        // of the clouds [m]; units of planar scans in a metre
  ScanPlaceSearch plan_;
  std::string doubt_;
};

}  // namespace hybrid
