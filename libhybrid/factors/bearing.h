// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/factor_of.h"
#include "libhybrid/factors/sensor_view.h"

namespace HYBRID_API hybrid {

/// The direction of a point seen by a sensor on a robot, without its distance: residual h(T, p) - z
/// wrapped to [-pi, pi], where z is the bearing in the plane and (yaw, pitch) in space [rad], with
/// the signs of `to_polar`; see there for points at the sensor or on its vertical axis.
template <class Pose>
class Bearing : public FactorOf<Pose::Point::RowsAtCompileTime - 1, Pose, typename Pose::Point> {
 public:
  using Point = typename Pose::Point;
  static constexpr int kRows = Point::RowsAtCompileTime - 1;
  using Base = FactorOf<kRows, Pose, Point>;
  using Angles = typename Base::Residual;

  /// Throws Error for an angle that is not finite.
  Bearing(Key pose, Key point, const Angles& measured, const Noise& noise,
          const Pose& T_robot_sensor = {}, Loss loss = {})
      : Base({pose, point}, noise, loss), measured_(measured), view_(T_robot_sensor) {
    check_measurement(*this, measured, "bearing");
  }

  const Angles& measured() const { return measured_; }
  const Pose& T_robot_sensor() const { return view_.T_robot_sensor(); }
  std::string name() const override { return "bearing"; }

  Angles evaluate(const Pose& T_map_robot, const Point& p_map,
                  typename Base::template Jacobian<Pose>* by_pose,
                  typename Base::template Jacobian<Point>* by_point) const override {
    typename SensorView<Pose>::PoseMatrix all_by_pose;
    typename SensorView<Pose>::Matrix all_by_point;
    const bool derive = by_pose != nullptr;
    const Point z = view_.polar(T_map_robot, p_map, derive ? &all_by_pose : nullptr, &all_by_point);
    if (derive) {
      *by_pose = all_by_pose.template bottomRows<kRows>();
      *by_point = all_by_point.template bottomRows<kRows>();
    }
    Angles e = z.template tail<kRows>() - measured_;
    for (double& angle : e) angle = wrap_angle(angle);
    return e;
  }

 private:
  Angles measured_;
  SensorView<Pose> view_;
};

using Bearing2 = Bearing<SE2>;
using Bearing3 = Bearing<SE3>;

}  // namespace hybrid
