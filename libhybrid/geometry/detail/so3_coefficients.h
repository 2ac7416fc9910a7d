// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include "libhybrid/geometry/eigen.h"

namespace hybrid::detail {

/// A function of the squared angle s = t^2 and its derivative with respect to s.
struct Coefficient {
  double value = 0.0;
  double derivative = 0.0;
};

/// I + f hat(v) + g hat(v)^2, the form of all SO(3) Jacobians.
Eigen::Matrix3d rotation_polynomial(const Eigen::Vector3d& v, double f, double g);

/// The same applied to a vector.
inline Eigen::Vector3d rotation_polynomial(const Eigen::Vector3d& v, double f, double g,
                                           const Eigen::Vector3d& x) {
  const Eigen::Vector3d vx = v.cross(x);
  return x + f * vx + g * v.cross(vx);
}

/// Derivative of `rotation_polynomial` at v in direction p, f and g being functions of |v|^2.
///
/// The adjoint of se(3), [hat(v) hat(p); 0 hat(v)], multiplies like the dual number v + eps p
/// (eps^2 = 0), so a Jacobian of SE(3), which is a power series in it, is [J D; 0 J] with J that of
/// SO(3) at v and D its derivative in direction p.
Eigen::Matrix3d rotation_polynomial_derivative(const Eigen::Vector3d& v, const Eigen::Vector3d& p,
                                               const Coefficient& f, const Coefficient& g);

/// f and g of the right Jacobian: -(1 - cos t) / t^2 and (t - sin t) / t^3.
struct RightJacobian {
  Coefficient f;
  Coefficient g;
  explicit RightJacobian(double s);
};

/// Below this squared angle the closed forms lose digits to cancellation and the series take over,
/// which have a relative error below 1e-12 there.
inline constexpr double kSmallSquare = 0.25;

/// The value of cot_coefficient at a small squared angle.
inline double cot_series(double s) {
  return 1.0 / 12 +
         s * (1.0 / 720 +
              s * (1.0 / 30240 +
                   s * (1.0 / 1209600 +
                        s * (1.0 / 47900160 + s * (691.0 / 1307674368000.0 + s / 74724249600.0)))));
}

/// g of the inverse right Jacobian, whose f is 1/2: 1 / t^2 - cot(t / 2) / (2 t), given cot(t / 2).
/// For small angles `half_cot` is not used.
Coefficient cot_coefficient(double s, double half_cot);

}  // namespace hybrid::detail
