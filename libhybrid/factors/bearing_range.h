// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/factor_of.h"
#include "libhybrid/factors/sensor_view.h"

namespace HYBRID_API hybrid {

/// A point seen by a range-bearing sensor on a robot, psi of eq. 19: residual h(T, p) - z with
/// angles wrapped to [-pi, pi], where z is (range, bearing) in the plane and (range, yaw, pitch) in
/// space, in the sensor frame with the signs of `to_polar`. Noise is over z in that order. With the
/// point at the sensor, or on its vertical axis, values and Jacobians are finite, see `to_polar`.
template <class Pose>
class BearingRange : public FactorOf<Pose::Point::RowsAtCompileTime, Pose, typename Pose::Point> {
 public:
  using Point = typename Pose::Point;
  using Base = FactorOf<Point::RowsAtCompileTime, Pose, Point>;

  /// Throws Error for a negative range or an entry that is not finite.
  BearingRange(Key pose, Key point, const Point& measured, const Noise& noise,
               const Pose& T_robot_sensor = {}, Loss loss = {})
      : Base({pose, point}, noise, loss), measured_(measured), view_(T_robot_sensor) {
    check_range(*this, measured[0]);
    check_measurement(*this, measured, "bearing");
  }

  const Point& measured() const { return measured_; }
  const Pose& T_robot_sensor() const { return view_.T_robot_sensor(); }
  std::string name() const override { return "bearing-range"; }

  /// The expected measurement; the Jacobians are written if they are not null (both or none).
  Point predict(const Pose& T_map_robot, const Point& p_map,
                typename Base::template Jacobian<Pose>* by_pose = nullptr,
                typename Base::template Jacobian<Point>* by_point = nullptr) const {
    return view_.polar(T_map_robot, p_map, by_pose, by_point);
  }

  typename Base::Residual evaluate(
      const Pose& T_map_robot, const Point& p_map, typename Base::template Jacobian<Pose>* by_pose,
      typename Base::template Jacobian<Point>* by_point) const override {
    Point e = predict(T_map_robot, p_map, by_pose, by_point) - measured_;
    for (int i = 1; i < e.size(); ++i) e[i] = wrap_angle(e[i]);
    return e;
  }

 private:
  Point measured_;
  SensorView<Pose> view_;
};

using BearingRange2 = BearingRange<SE2>;
using BearingRange3 = BearingRange<SE3>;

/// A point in the map and its covariance.
template <class Point>
struct LocatedPoint {
  Point mean;
  Eigen::Matrix<double, Point::RowsAtCompileTime, Point::RowsAtCompileTime> covariance;
};

/// The position of a measured point in the map (the inverse of `BearingRange`) and its covariance
/// to first order, from the noise of the measurement and, if given, the covariance of the robot
/// pose in its tangent.
template <class Pose>
LocatedPoint<typename Pose::Point> locate(
    const Pose& T_map_robot, const typename Pose::Point& measured, const Noise& noise,
    const Pose& T_robot_sensor = {},
    const typename Pose::Jacobian& pose_covariance = Pose::Jacobian::Zero()) {
  using View = SensorView<Pose>;
  typename View::Matrix J;
  const auto p_robot = T_robot_sensor * from_polar(measured, &J);
  const typename View::Matrix R = T_map_robot.rotation().matrix();
  const typename View::Matrix by_measured = R * T_robot_sensor.rotation().matrix() * J;
  typename View::PoseMatrix by_pose;
  by_pose << R, -R * rotation_derivative(p_robot);
  return {T_map_robot * p_robot, by_measured * noise.covariance() * by_measured.transpose() +
                                     by_pose * pose_covariance * by_pose.transpose()};
}

}  // namespace hybrid
