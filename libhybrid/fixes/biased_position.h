// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "libhybrid/factors/carried_point.h"
#include "libhybrid/factors/factor_of.h"

namespace HYBRID_API hybrid {

/// A measured position [m] in the map of a point fixed on a robot, e.g. its satellite antenna at
/// `lever_arm` in the robot frame, with an error that several measurements have in common, which is
/// a variable: residual T lever_arm + error - z, in the axes of the map.
template <class Pose>
class BiasedPosition : public FactorOf<Pose::Point::RowsAtCompileTime, Pose, typename Pose::Point> {
 public:
  using Point = typename Pose::Point;
  using Base = FactorOf<Point::RowsAtCompileTime, Pose, Point>;

  /// Throws Error for an entry that is not finite.
  BiasedPosition(Key pose, Key error, const Point& measured, const Noise& noise,
                 const Point& lever_arm = Point::Zero(), Loss loss = {})
      : Base({pose, error}, noise, loss), measured_(measured), lever_arm_(lever_arm) {
    check_measurement(*this, measured, "position");
  }

  std::string name() const override { return "position with a lasting error"; }

  Point evaluate(const Pose& T_map_robot, const Point& error,
                 typename Base::template Jacobian<Pose>* J_robot,
                 typename Base::template Jacobian<Point>* J_error) const override {
    if (J_error != nullptr) J_error->setIdentity();
    return carried_point(T_map_robot, lever_arm_, J_robot) + error - measured_;
  }

 private:
  Point measured_;
  Point lever_arm_;
};

}  // namespace hybrid
