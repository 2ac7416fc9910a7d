// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>

#include "libhybrid/geometry/points.h"
#include "libhybrid/registration/target_cloud.h"

namespace hybrid {

/// The position and the extent of a cloud.
struct CloudSpread {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  Eigen::Matrix3d axes = Eigen::Matrix3d::Identity();  ///< principal axes as columns
  Eigen::Vector3d sigmas = Eigen::Vector3d::Zero();    ///< along the axes, ascending
  double radius() const { return sigmas.norm(); }      ///< root mean square from the centre
};

CloudSpread spread_of(const Points& points);

/// The 0.8 quantile of the distance to the nearest neighbour, over a sample of the cloud.
double spacing_of(const Points& points);

/// One point per occupied cell of a cubic grid: the mean of those inside, in order of their first.
Points subsample(const Points& points, double cell);

/// The local shape of a target: curves for a plane scan, whose points are in one plane and in lines
/// locally; points if one of the clouds is a line; else surfaces.
LocalShape local_shape(const Points& source, const Points& target);

/// The resolution of registration, as a share of the extent of a cloud.
inline constexpr double kLeastSpacing = 2e-4;

/// Throws Error, beginning with `what`, for fewer than three points, one that is not finite, points
/// that all coincide, or nine of ten that coincide at the scale of the farthest.
void check_cloud(const Points& points, const std::string& what);

}  // namespace hybrid
