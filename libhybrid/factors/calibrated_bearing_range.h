// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/factor_of.h"
#include "libhybrid/factors/sensor_view.h"

namespace HYBRID_API hybrid {

/// BearingRange with the pose of the sensor on the robot, T_robot_sensor, as a third variable that
/// all sightings of the sensor share.
template <class Pose>
class CalibratedBearingRange
    : public FactorOf<Pose::Point::RowsAtCompileTime, Pose, typename Pose::Point, Pose> {
 public:
  using Point = typename Pose::Point;
  using Base = FactorOf<Point::RowsAtCompileTime, Pose, Point, Pose>;
  using PoseJacobian = typename Base::template Jacobian<Pose>;
  using PointJacobian = typename Base::template Jacobian<Point>;

  /// Throws Error for a negative range or an entry that is not finite.
  CalibratedBearingRange(Key pose, Key point, Key sensor, const Point& measured, const Noise& noise,
                         Loss loss = {})
      : Base({pose, point, sensor}, noise, loss), measured_(measured) {
    check_range(*this, measured[0]);
    check_measurement(*this, measured, "bearing");
  }

  const Point& measured() const { return measured_; }
  std::string name() const override { return "calibrated bearing-range"; }

  typename Base::Residual evaluate(const Pose& T_map_robot, const Point& p_map,
                                   const Pose& T_robot_sensor, PoseJacobian* by_pose,
                                   PointJacobian* by_point,
                                   PoseJacobian* by_sensor) const override {
    const SensorView<Pose> view(T_robot_sensor);
    Point e = view.polar(T_map_robot, p_map, by_pose, by_point, by_sensor) - measured_;
    for (int i = 1; i < e.size(); ++i) e[i] = wrap_angle(e[i]);
    return e;
  }

 private:
  Point measured_;
};

using CalibratedBearingRange2 = CalibratedBearingRange<SE2>;
using CalibratedBearingRange3 = CalibratedBearingRange<SE3>;

}  // namespace hybrid
