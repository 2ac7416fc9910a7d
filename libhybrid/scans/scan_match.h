// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/scans/correlative_search.h"
#include "libhybrid/scans/likelihood_field.h"
#include "libhybrid/scans/scan_alignment.h"
#include "libhybrid/scans/scan_motion.h"
#include "libhybrid/scans/surface_map.h"

namespace HYBRID_API hybrid {

/// A map to match scans with: surfaces for the precise pose, a field for the search.
struct MatchTarget {
  SurfaceMap surfaces;
  LikelihoodField field;
};

/// Joins points in the frame of the map.
MatchTarget make_match_target(const std::vector<SurfacePoint>& points);

/// A pose of points in a map at which they agree.
struct MatchMode {
  UncertainMotion pose;  ///< of the frame of the points in that of the map
  double inliers = 0.0;  ///< share of the points that lie on a surface of the map
};

struct MatchOptions {
  SearchOptions search;
  double min_inliers = 0.5;  ///< modes of a smaller share are left out
  int most_points = 200;     ///< that the search uses, evenly chosen
};

/// Covariance of an alignment: inverse of its information, with a floor for what all its points
/// share, such as the spacing of the rays. What the points do not tell at all has a standard
/// deviation of 20 m and 2 rad.
Eigen::Matrix3d alignment_covariance(const ScanAlignment& alignment);

/// All modes of the pose of points in a map within a window, best first: those found by
/// correlative search, aligned.
std::vector<MatchMode> match(const std::vector<SurfacePoint>& points, const MatchTarget& target,
                             const SearchWindow& window, const MatchOptions& options = {});

}  // namespace hybrid
