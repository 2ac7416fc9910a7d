// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"

namespace HYBRID_API hybrid {

/// The position in the map of the point `offset`, given in the frame of a pose (e.g. an antenna on
/// a robot). `J`, if not null, receives the Jacobian with respect to the pose.
inline Eigen::Vector2d carried_point(const SE2& T, const Eigen::Vector2d& offset,
                                     Eigen::Matrix<double, 2, 3>* J = nullptr) {
  const Eigen::Matrix2d R = T.rotation().matrix();
  if (J != nullptr) *J << R, R * Eigen::Vector2d(-offset.y(), offset.x());
  return T.translation() + R * offset;
}

inline Eigen::Vector3d carried_point(const SE3& T, const Eigen::Vector3d& offset,
                                     Eigen::Matrix<double, 3, 6>* J = nullptr) {
  const Eigen::Matrix3d R = T.rotation().matrix();
  if (J != nullptr) *J << R, -R * hat(offset);
  return T.translation() + R * offset;
}

/// The same for a variable that is a point: an offset in the axes of the map.
template <int N>
Eigen::Matrix<double, N, 1> carried_point(const Eigen::Matrix<double, N, 1>& p,
                                          const Eigen::Matrix<double, N, 1>& offset,
                                          Eigen::Matrix<double, N, N>* J = nullptr) {
  if (J != nullptr) J->setIdentity();
  return p + offset;
}

/// The point type of a variable that has a position: Vector2d for SE2, Vector3d for SE3, a vector's
/// own type for a vector.
template <class T>
struct PositionOf {
  using type = typename T::Point;
};
template <int N>
struct PositionOf<Eigen::Matrix<double, N, 1>> {
  using type = Eigen::Matrix<double, N, 1>;
};

}  // namespace hybrid
