// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/clouds/cloud_alignment.h"
#include "libhybrid/scans/likelihood_field.h"

namespace HYBRID_API hybrid {

/// Surfaces to match clouds with: as they are for the precise pose, walls and poles seen from above
/// for the search.
struct CloudTarget {
  CloudSurfaces surfaces;
  LikelihoodField walls;                                ///< of a level frame
  Eigen::Matrix3d level = Eigen::Matrix3d::Identity();  ///< turns the frame of the surfaces to it
};

/// `T_map_frame`: where the frame of the points is in one whose z axis points up.
CloudTarget make_cloud_target(const std::vector<CloudPoint>& points, double spacing,
                              const SE3& T_map_frame);

struct CloudMatchOptions {
  double max_reach = 20;           ///< half the width of the window of a search, at most [m]
  double max_turn = 0.8;           ///< and of its angle about the vertical, at most [rad]
  double min_inliers = 0.5;        ///< poses of a smaller share are left out
  std::size_t most_points = 2000;  ///< that are matched, evenly chosen
};

/// Whether two poses are one, for surfaces of that spacing [m].
bool are_one_pose(const SE3& a, const SE3& b, double spacing);

/// All poses of points in a target that a prediction allows, the likeliest first.
std::vector<CloudAlignment> match(const std::vector<CloudPoint>& points, const CloudTarget& target,
                                  const UncertainMotion3& predicted,
                                  const CloudMatchOptions& options);

}  // namespace hybrid
