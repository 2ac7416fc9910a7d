// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/geometry/se3.h"

namespace HYBRID_API hybrid {

/// A place on a surface that a lidar or a depth camera has seen.
struct CloudPoint {
  Eigen::Vector3f position = Eigen::Vector3f::Zero();  ///< [m]
  /// Unit normal, towards the sensor; zero where the points around tell none.
  Eigen::Vector3f normal = Eigen::Vector3f::Zero();

  bool has_normal() const { return !normal.isZero(); }
};

/// The median distance of the points from the sensor [m], between 0.5 and 30: the scale of what it
/// sees, by which lengths of maps of clouds are chosen. 0 where there are fewer than 100 points.
double reach_of(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& sensor);

/// One point for each cube of edge `spacing` [m] that has any: the mean of its points, moved onto
/// the plane of those in it and in the cubes around where these are a surface, with the normal of
/// that. Points that are not finite, or farther than 1 km, are left out. `sensor`: where the points
/// were seen from.
std::vector<CloudPoint> cloud_points(const std::vector<Eigen::Vector3f>& points,
                                     const Eigen::Vector3f& sensor, double spacing);

std::vector<CloudPoint> transformed(const SE3& T, const std::vector<CloudPoint>& points);

/// The mean of positions; zero where there is none.
Eigen::Vector3d middle_of(const std::vector<CloudPoint>& points);

}  // namespace hybrid
