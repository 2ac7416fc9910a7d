// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

// The example of docs/writing_a_factor.md; what stands between the two marks is quoted there.
// [example]
#include <string>

#include "libhybrid/factors/factor_of.h"

/// The distance [m] from a robot to a straight wall n' p = d, measured by a sonar: residual
/// d - n' t - z, where t is the robot's position and n the unit normal away from the robot's side.
class WallDistance : public hybrid::FactorOf<1, hybrid::SE2> {
 public:
  WallDistance(hybrid::Key pose, const Eigen::Vector2d& normal, double d, double measured,
               const hybrid::Noise& noise, hybrid::Loss loss = {})
      : FactorOf({pose}, noise, loss), normal_(normal), d_(d), measured_(measured) {}

  std::string name() const override { return "wall distance"; }

  Residual evaluate(const hybrid::SE2& T_map_robot, Jacobian<hybrid::SE2>* J) const override {
    // A step (v, w) of the tangent moves the position by R v, to first order, and w does not.
    if (J != nullptr) *J << -normal_.transpose() * T_map_robot.rotation().matrix(), 0.0;
    return Residual(d_ - normal_.dot(T_map_robot.translation()) - measured_);
  }

 private:
  Eigen::Vector2d normal_;
  double d_;
  double measured_;
};
// [example]
