// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// A point whose position is known in two frames [m].
struct CommonPoint {
  Eigen::Vector3d first, second;
};

/// Where one frame is in another.
struct AlignedFrames {
  Eigen::Isometry3d T_first_second = Eigen::Isometry3d::Identity();
  /// Of it, in the tangent of a right perturbation, 3x3 in the plane, 6x6 in space. Errors of
  /// positions in a map are alike, so that it is that of one point, however many there are.
  Eigen::MatrixXd covariance;
  double sigma = 0;          ///< of the differences of the points that agree, along each axis [m]
  std::size_t agreeing = 0;  ///< points
  double log_odds = 0;       ///< for the frames being so against any other way
};

/// The motion between two frames by points known in both, of which fewer than half may be wrong:
/// that with the least median distance (least median of squares), improved by the points that agree
/// with it. The scale of errors is found from them, too. Points speak for it by how much less their
/// differences scatter than they do themselves, those nearer to each other than two sigmas as one.
/// Nothing where that is less than `odds`, or the motion not determined.
std::optional<AlignedFrames> align_frames(const std::vector<CommonPoint>& points, bool is_3d,
                                          double odds);

}  // namespace hybrid
