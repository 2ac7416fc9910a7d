// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "libhybrid/geometry/eigen.h"

namespace hybrid {

/// Jacobian of the distance of a point along a direction, by the tangent of the pose of the frame
/// that both are in.
inline Eigen::Matrix<double, 6, 1> distance_row(const Eigen::Vector3d& direction,
                                                const Eigen::Vector3d& point) {
  Eigen::Matrix<double, 6, 1> out;
  out << direction, point.cross(direction);
  return out;
}

}  // namespace hybrid
