// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <string>

#include "libhybrid/factors/carried_point.h"
#include "libhybrid/factors/factor_of.h"
#include "libhybrid/factors/sensor_view.h"

namespace HYBRID_API hybrid {

/// A measured position [m] in the map of a point fixed on a robot, e.g. its satellite antenna at
/// `lever_arm` in the robot frame: residual T lever_arm - z, in the axes of the map.
template <class Pose>
class Position : public FactorOf<Pose::Point::RowsAtCompileTime, Pose> {
 public:
  using Point = typename Pose::Point;
  using Base = FactorOf<Point::RowsAtCompileTime, Pose>;

  /// Throws Error for an entry that is not finite.
  Position(Key pose, const Point& measured, const Noise& noise,
           const Point& lever_arm = Point::Zero(), Loss loss = {})
      : Base({pose}, noise, loss), measured_(measured), lever_arm_(lever_arm) {
    check_measurement(*this, measured, "position");
  }

  const Point& measured() const { return measured_; }
  const Point& lever_arm() const { return lever_arm_; }
  std::string name() const override { return "position"; }

  Point evaluate(const Pose& T_map_robot,
                 typename Base::template Jacobian<Pose>* J) const override {
    return carried_point(T_map_robot, lever_arm_, J) - measured_;
  }

 private:
  Point measured_;
  Point lever_arm_;
};

using Position2 = Position<SE2>;
using Position3 = Position<SE3>;

}  // namespace hybrid
