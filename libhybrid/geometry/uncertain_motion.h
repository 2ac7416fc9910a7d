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

/// The covariance of a pose in space whose errors along and about all axes are independent, by
/// their standard deviations [m], [rad].
inline SE3::Jacobian isotropic_covariance(double translation, double rotation) {
  SE3::Tangent sigmas;
  sigmas << Eigen::Vector3d::Constant(translation), Eigen::Vector3d::Constant(rotation);
  return sigmas.cwiseAbs2().asDiagonal();
}

/// One motion after another, whose errors are independent.
template <class Pose>
Uncertain<Pose> operator*(const Uncertain<Pose>& a, const Uncertain<Pose>& b) {
  const typename Pose::Jacobian Ad = b.motion.inverse().adjoint();
  return {a.motion * b.motion, Ad * a.covariance * Ad.transpose() + b.covariance};
}

/// The way back.
template <class Pose>
Uncertain<Pose> inverse(const Uncertain<Pose>& a) {
  const typename Pose::Jacobian Ad = a.motion.adjoint();
  return {a.motion.inverse(), Ad * a.covariance * Ad.transpose()};
}

}  // namespace hybrid
