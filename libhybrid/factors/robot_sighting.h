// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/carried_point.h"
#include "libhybrid/factors/factor_of.h"
#include "libhybrid/factors/sensor_view.h"

namespace HYBRID_API hybrid {

/// A robot seen by a range-bearing sensor on another one: as BearingRange, of the point `offset` in
/// the frame of the robot seen [m].
template <class Pose>
class RobotSighting : public FactorOf<Pose::Point::RowsAtCompileTime, Pose, Pose> {
 public:
  using Point = typename Pose::Point;
  using Base = FactorOf<Point::RowsAtCompileTime, Pose, Pose>;
  using PoseJacobian = typename Base::template Jacobian<Pose>;

  /// Throws Error for a negative range or an entry that is not finite.
  RobotSighting(Key observer, Key seen, const Point& measured, const Noise& noise,
                const Pose& T_robot_sensor = {}, const Point& offset = Point::Zero(),
                Loss loss = {})
      : Base({observer, seen}, noise, loss),
        measured_(measured),
        offset_(offset),
        view_(T_robot_sensor) {
    check_range(*this, measured[0]);
    check_measurement(*this, measured, "bearing");
    check_measurement(*this, offset, "offset");
  }

  std::string name() const override { return "robot-sighting"; }

  typename Base::Residual evaluate(const Pose& T_map_observer, const Pose& T_map_seen,
                                   PoseJacobian* by_observer,
                                   PoseJacobian* by_seen) const override {
    PoseJacobian by_carrier;
    Eigen::Matrix<double, Point::RowsAtCompileTime, Point::RowsAtCompileTime> by_point;
    const bool wanted = by_observer != nullptr;
    const Point p = carried_point(T_map_seen, offset_, wanted ? &by_carrier : nullptr);
    Point e = view_.polar(T_map_observer, p, by_observer, &by_point) - measured_;
    if (wanted) by_seen->noalias() = by_point * by_carrier;
    for (int i = 1; i < e.size(); ++i) e[i] = wrap_angle(e[i]);
    return e;
  }

 private:
  Point measured_, offset_;
  SensorView<Pose> view_;
};

using RobotSighting2 = RobotSighting<SE2>;
using RobotSighting3 = RobotSighting<SE3>;

}  // namespace hybrid
