// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/core/values.h"

namespace HYBRID_API hybrid {

/// Moves a pose or a point rigidly, as `motion` (SE2 or SE3) says; other variables stay.
template <class Pose>
void move_variable(const Pose& motion, Key key, Values& values) {
  using Point = typename Pose::Point;
  if (values.type(key) == Variable<Pose>::type()) {
    Pose pose = motion * values.at<Pose>(key);
    pose.normalize();
    values.update(key, pose);
  } else if (values.type(key) == Variable<Point>::type()) {
    values.update(key, Point(motion * values.at<Point>(key)));
  }
}

}  // namespace hybrid
