// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <string>

#include "libhybrid/core/error.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"

namespace HYBRID_API hybrid {

/// Derivative of R' p with respect to the right perturbation of R, given q = R' p.
inline Eigen::Vector2d rotation_derivative(const Eigen::Vector2d& q) {
  return {q.y(), -q.x()};
}
inline Eigen::Matrix3d rotation_derivative(const Eigen::Vector3d& q) {
  return hat(q);
}

/// The measurement of a point of the map by a sensor fixed on a robot (SE2 or SE3).
template <class Pose>
class SensorView {
 public:
  using Point = typename Pose::Point;
  static constexpr int kPointDim = Point::RowsAtCompileTime;
  using Matrix = Eigen::Matrix<double, kPointDim, kPointDim>;
  using PoseMatrix = Eigen::Matrix<double, kPointDim, Pose::kDim>;

  explicit SensorView(const Pose& T_robot_sensor)
      : T_robot_sensor_(T_robot_sensor),
        R_sensor_robot_(T_robot_sensor.rotation().matrix().transpose()) {}

  const Pose& T_robot_sensor() const { return T_robot_sensor_; }

  /// Polar coordinates, in the sensor frame, of a point given in the map. The Jacobians are written
  /// unless `by_pose` is null; `by_sensor`, with respect to the pose of the sensor on the robot,
  /// may be null.
  Point polar(const Pose& T_map_robot, const Point& p_map, PoseMatrix* by_pose, Matrix* by_point,
              PoseMatrix* by_sensor = nullptr) const {
    const Matrix R_robot_map = T_map_robot.rotation().matrix().transpose();
    const Point p_robot = R_robot_map * (p_map - T_map_robot.translation());
    const Point p_sensor = R_sensor_robot_ * (p_robot - T_robot_sensor_.translation());
    if (by_pose == nullptr) return to_polar(p_sensor);
    Matrix J;
    const Point z = to_polar(p_sensor, &J);
    const Matrix by_robot = J * R_sensor_robot_;
    by_pose->template leftCols<kPointDim>() = -by_robot;
    by_pose->template rightCols<Pose::kDim - kPointDim>().noalias() =
        by_robot * rotation_derivative(p_robot);
    by_point->noalias() = by_robot * R_robot_map;
    if (by_sensor != nullptr) {
      by_sensor->template leftCols<kPointDim>() = -J;
      by_sensor->template rightCols<Pose::kDim - kPointDim>().noalias() =
          J * rotation_derivative(p_sensor);
    }
    return z;
  }

 private:
  Pose T_robot_sensor_;
  Matrix R_sensor_robot_;
};

}  // namespace hybrid
