// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/clouds/cloud_surfaces.h"
#include "libhybrid/geometry/uncertain_motion.h"

namespace HYBRID_API hybrid {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

struct CloudAlignmentOptions {
  int max_iterations = 20;
  bool with_information = true;  ///< else CloudAlignment::information is left at zero
  /// Information about the start, in its tangent; it keeps in place what the points do not tell.
  Matrix6 prior = Matrix6::Zero();
};

/// Tangents are (translation [m], rotation vector [rad]), in the frame of the points.
struct CloudAlignment {
  SE3 pose;  ///< of the frame of the points in that of the map
  /// Of the points alone, without the prior: near zero along a tunnel.
  Matrix6 information = Matrix6::Zero();
  double inliers = 0;  ///< share of the points that lie on a surface of the map
  /// The same, each counted by how near to its surface it is: 1 on it, 0 where it no longer lies on
  /// it. Of two poses, the one of larger support is the likelier.
  double support = 0;
  double sigma = 0;  ///< scatter of these around the surfaces, robust [m]
};

/// Moves points onto the surfaces of a map: distances to planes, a robust loss (Geman and McClure),
/// the least cost near `start`. Points without a normal are not used.
CloudAlignment align(const std::vector<CloudPoint>& points, const CloudSurfaces& map,
                     const SE3& start, const CloudAlignmentOptions& options = {});

/// What a point in the frame of the map adds to CloudAlignment::support.
double support_of(const CloudPoint& point, const CloudSurfaces& map);

/// What a point with that distance from its surface [m] counts in an alignment of such a scatter
/// [m] to a map of such a spacing [m]: information about the distance [1/m^2].
double pairing_weight(double residual, double sigma, double spacing);

/// The covariance of an alignment, with the errors that all of its points share: those of the
/// sensor and of the map.
Matrix6 alignment_covariance(const CloudAlignment& alignment);

}  // namespace hybrid
