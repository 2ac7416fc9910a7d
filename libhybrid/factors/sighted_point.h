// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/factor_of.h"
#include "libhybrid/factors/sensor_view.h"

namespace HYBRID_API hybrid {

/// A measured position z [m] of a landmark in the frame of the robot that sees it: residual
/// T^-1 p - z.
template <class Pose>
class SightedPoint : public FactorOf<Pose::Point::RowsAtCompileTime, Pose, typename Pose::Point> {
 public:
  using Point = typename Pose::Point;
  static constexpr int kPointDim = Point::RowsAtCompileTime;
  using Base = FactorOf<kPointDim, Pose, Point>;

  /// Throws Error for an entry that is not finite.
  SightedPoint(Key pose, Key point, const Point& measured, const Noise& noise, Loss loss = {})
      : Base({pose, point}, noise, loss), measured_(measured) {
    check_measurement(*this, measured, "position");
  }

  const Point& measured() const { return measured_; }
  std::string name() const override { return "sighted point"; }

  typename Base::Residual evaluate(
      const Pose& T_map_robot, const Point& p_map, typename Base::template Jacobian<Pose>* by_pose,
      typename Base::template Jacobian<Point>* by_point) const override {
    const Eigen::Matrix<double, kPointDim, kPointDim> R_robot_map =
        T_map_robot.rotation().matrix().transpose();
    const Point p_robot = R_robot_map * (p_map - T_map_robot.translation());
    if (by_pose != nullptr) {
      by_pose->template leftCols<kPointDim>() =
          -Eigen::Matrix<double, kPointDim, kPointDim>::Identity();
      by_pose->template rightCols<Pose::kDim - kPointDim>() = rotation_derivative(p_robot);
      *by_point = R_robot_map;
    }
    return p_robot - measured_;
  }

 private:
  Point measured_;
};

}  // namespace hybrid
