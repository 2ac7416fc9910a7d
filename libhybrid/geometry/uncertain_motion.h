// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"

namespace HYBRID_API hybrid {

/// A motion with its covariance, in the tangent of a right perturbation.
template <class Pose>
struct Uncertain {
  Pose motion;
  typename Pose::Jacobian covariance = Pose::Jacobian::Identity();
};

using UncertainMotion = Uncertain<SE2>;   ///< tangent (x, y [m], angle [rad])
using UncertainMotion3 = Uncertain<SE3>;  ///< tangent (translation [m], rotation vector [rad])

/// One motion after another, whose errors are independent.
template <class Pose>
Uncertain<Pose> operator*(const Uncertain<Pose>& a, const Uncertain<Pose>& b) {
  const typename Pose::Jacobian Ad = b.motion.inverse().adjoint();
  return {a.motion * b.motion, Ad * a.covariance * Ad.transpose() + b.covariance};
}

}  // namespace hybrid
