// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/geometry/so3.h"

#include <cmath>

#include "libhybrid/geometry/arc.h"
#include "libhybrid/geometry/detail/so3_coefficients.h"

namespace hybrid {

SO3 SO3::exp(const Tangent& v) {
  const double t2 = v.squaredNorm();
  const double t = std::sqrt(t2);
  const double k = t < 1e-4 ? 0.5 - t2 / 48.0 : std::sin(0.5 * t) / t;
  const double w = t < 1e-4 ? 1.0 - t2 / 8.0 : std::cos(0.5 * t);
  return {Eigen::Quaterniond(w, k * v.x(), k * v.y(), k * v.z()), Unit()};
}

SO3::Tangent SO3::log(Jacobian* inverse) const {
  const double sign = q_.w() < 0.0 ? -1.0 : 1.0;
  const double w = sign * q_.w();
  const double n2 = q_.vec().squaredNorm();
  const double k = n2 < detail::kSmallTangent * w * w
                       ? 2.0 / w * detail::arc_series(n2 / (w * w))
                       : 2.0 * std::atan2(std::sqrt(n2), w) / std::sqrt(n2);
  const Tangent v = sign * k * q_.vec();
  if (inverse != nullptr) {
    const double g = detail::cot_coefficient(v.squaredNorm(), half_cot()).value;
    *inverse = detail::rotation_polynomial(v, 0.5, g);
  }
  return v;
}

SO3::Jacobian SO3::right_jacobian(const Tangent& v) {
  const detail::RightJacobian j(v.squaredNorm());
  return detail::rotation_polynomial(v, j.f.value, j.g.value);
}

SO3::Jacobian SO3::right_jacobian_inverse(const Tangent& v) {
  const double s = v.squaredNorm();
  const double g = detail::cot_coefficient(s, 1.0 / std::tan(0.5 * std::sqrt(s))).value;
  return detail::rotation_polynomial(v, 0.5, g);
}

}  // namespace hybrid
