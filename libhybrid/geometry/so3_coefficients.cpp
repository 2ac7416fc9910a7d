// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/geometry/detail/so3_coefficients.h"

#include <cmath>

namespace hybrid::detail {

Eigen::Matrix3d rotation_polynomial(const Eigen::Vector3d& v, double f, double g) {
  // hat(v)^2 = v v' - |v|^2 I.
  const double x = g * v.x(), y = g * v.y(), z = g * v.z();
  const double xx = x * v.x(), yy = y * v.y(), zz = z * v.z();
  const double xy = x * v.y(), xz = x * v.z(), yz = y * v.z();
  const Eigen::Vector3d w = f * v;
  Eigen::Matrix3d m;
  m << 1.0 - yy - zz, xy - w.z(), xz + w.y(),  //
      xy + w.z(), 1.0 - xx - zz, yz - w.x(),   //
      xz - w.y(), yz + w.x(), 1.0 - xx - yy;
  return m;
}

Eigen::Matrix3d rotation_polynomial_derivative(const Eigen::Vector3d& v, const Eigen::Vector3d& p,
                                               const Coefficient& f, const Coefficient& g) {
  const double ds = 2.0 * v.dot(p);  // derivative of s
  const double df = f.derivative * ds;
  const double dg = g.derivative * ds;
  // d(f v) for the antisymmetric part; d(g v v') = v u' + u v' with u = g p + dg v / 2, and its
  // trace taken off the diagonal.
  const Eigen::Vector3d w = f.value * p + df * v;
  const Eigen::Vector3d u = g.value * p + 0.5 * dg * v;
  const double xx = 2.0 * v.x() * u.x(), yy = 2.0 * v.y() * u.y(), zz = 2.0 * v.z() * u.z();
  const double xy = v.x() * u.y() + v.y() * u.x();
  const double xz = v.x() * u.z() + v.z() * u.x();
  const double yz = v.y() * u.z() + v.z() * u.y();
  Eigen::Matrix3d m;
  m << -yy - zz, xy - w.z(), xz + w.y(),  //
      xy + w.z(), -xx - zz, yz - w.x(),   //
      xz - w.y(), yz + w.x(), -xx - yy;
  return m;
}

RightJacobian::RightJacobian(double s) {
  if (s < kSmallSquare) {
    f.value = -1.0 / 2 +
              s * (1.0 / 24 -
                   s * (1.0 / 720 - s * (1.0 / 40320 - s * (1.0 / 3628800 - s / 479001600.0))));
    f.derivative = 1.0 / 24 - s * (1.0 / 360 -
                                   s * (1.0 / 13440 - s * (1.0 / 907200 - s * (1.0 / 95800320.0))));
    g.value = 1.0 / 6 -
              s * (1.0 / 120 -
                   s * (1.0 / 5040 - s * (1.0 / 362880 - s * (1.0 / 39916800 - s / 6227020800.0))));
    g.derivative =
        -1.0 / 120 +
        s * (1.0 / 2520 - s * (1.0 / 120960 - s * (1.0 / 9979200 - s * (1.0 / 1245404160.0))));
    return;
  }
  const double t = std::sqrt(s);
  f.value = (std::cos(t) - 1.0) / s;
  g.value = (t - std::sin(t)) / (s * t);
  f.derivative = -(1.0 - s * g.value + 2.0 * f.value) / (2.0 * s);
  g.derivative = -(f.value + 3.0 * g.value) / (2.0 * s);
}

Coefficient cot_coefficient(double s, double half_cot) {
  if (s < kSmallSquare) {
    return {cot_series(s),
            1.0 / 720 +
                s * (1.0 / 15120 +
                     s * (1.0 / 403200 + s * (1.0 / 11975040 + s * (3455.0 / 1307674368000.0 +
                                                                    s * (6.0 / 74724249600.0)))))};
  }
  const double k = half_cot / (2.0 * std::sqrt(s));
  return {1.0 / s - k, (0.125 + 0.5 * k * (1.0 + s * k) - 1.0 / s) / s};
}

}  // namespace hybrid::detail
