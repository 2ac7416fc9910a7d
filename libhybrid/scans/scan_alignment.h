// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/scans/scan_points.h"
#include "libhybrid/scans/surface_map.h"

namespace HYBRID_API hybrid {

struct AlignmentOptions {
  double radius = 0.4;  ///< of the search for counterparts at the start [m]
  int max_iterations = 20;
  /// Information about the start, in its tangent; it keeps in place what the points do not tell.
  Eigen::Matrix3d prior = Eigen::Matrix3d::Zero();
  /// Along a surface, errors of returns and of the map are one error over this length [m], so that
  /// closer points count as less than one.
  double correlation_length = 0.3;
};

/// Points aligned with a map of surfaces.
struct ScanAlignment {
  SE2 pose;  ///< of the frame of the points in that of the map
  /// Of the points alone, without the prior, in the tangent of the pose: near zero along a
  /// corridor.
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  double inliers = 0.0;  ///< share of the points that lie on a surface of the map
  /// Number of these, each counted by its share of the correlation length, and by how near to its
  /// surface it is: 1 on it, 0 where it no longer lies on it.
  double support = 0.0;
  double sigma = 0.0;  ///< scatter of these around the surfaces, robust [m]
};

/// Least squares of the distances from points to the lines of nearest surfels, under a robust loss
/// whose scale is that of the residuals.
ScanAlignment align(const std::vector<SurfacePoint>& points, const SurfaceMap& map,
                    const SE2& start, const AlignmentOptions& options = {});

}  // namespace hybrid
