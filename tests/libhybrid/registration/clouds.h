// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <cmath>

#include "libhybrid/geometry/points.h"
#include "libhybrid/geometry/se3.h"
#include "tests/support/random.h"

namespace hybrid::testing {

/// Points on a bumpy closed surface without symmetry, about one unit across, with noise.
inline Points bumpy_surface(int count, double noise, Random& random) {
  Points points;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d u = random.vector<3>().normalized();
    const double r = 1.0 + 0.3 * std::sin(3.0 * u.x() + 1.0) + 0.2 * std::cos(4.0 * u.y()) +
                     0.25 * u.z() * u.z() * u.x();
    points.push_back(r * u.cwiseProduct(Eigen::Vector3d(1.0, 0.8, 0.6)) + random.vector<3>(noise));
  }
  return points;
}

inline Points moved(const SE3& T, Points points) {
  for (Eigen::Vector3d& p : points) p = T * p;
  return points;
}

inline double angle(const SE3& T) {
  return T.rotation().log().norm();
}

}  // namespace hybrid::testing
