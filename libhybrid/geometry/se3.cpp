// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/geometry/se3.h"

#include <cmath>

#include "libhybrid/geometry/detail/so3_coefficients.h"

namespace hybrid {
namespace {

SE3::Jacobian upper(const Eigen::Matrix3d& diagonal, const Eigen::Matrix3d& corner) {
  SE3::Jacobian m;
  m << diagonal, corner, Eigen::Matrix3d::Zero(), diagonal;
  return m;
}

/// The inverse of the right Jacobian from the coefficient of hat(rotation)^2 in it.
SE3::Jacobian inverse_jacobian(const SE3::Tangent& v, const detail::Coefficient& g) {
  const Eigen::Vector3d w = v.tail<3>();
  return upper(detail::rotation_polynomial(w, 0.5, g.value),
               detail::rotation_polynomial_derivative(w, v.head<3>(), {0.5, 0.0}, g));
}

}  // namespace

Eigen::Matrix4d SE3::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = rotation_.matrix();
  m.topRightCorner<3, 1>() = translation_;
  return m;
}

SE3 SE3::exp(const Tangent& v) {
  // The left Jacobian of SO(3), which multiplies the translation, is the right one transposed.
  const Eigen::Vector3d w = v.tail<3>();
  const detail::RightJacobian j(w.squaredNorm());
  return {detail::rotation_polynomial(w, -j.f.value, j.g.value, v.head<3>()), SO3::exp(w)};
}

SE3::Tangent SE3::log(Jacobian* inverse) const {
  const Eigen::Vector3d w = rotation_.log();
  const double s = w.squaredNorm();
  Tangent v;
  if (inverse == nullptr && s < detail::kSmallSquare) {
    v << detail::rotation_polynomial(w, -0.5, detail::cot_series(s), translation_), w;
    return v;
  }
  const detail::Coefficient g = detail::cot_coefficient(s, rotation_.half_cot());
  v << detail::rotation_polynomial(w, -0.5, g.value, translation_), w;
  if (inverse != nullptr) *inverse = inverse_jacobian(v, g);
  return v;
}

SE3::Jacobian SE3::adjoint() const {
  const Eigen::Matrix3d r = rotation_.matrix();
  return upper(r, hat(translation_) * r);
}

SE3::Jacobian SE3::times_inverse_adjoint(const Jacobian& J) const {
  // The adjoint of the inverse is [R' -R' hat(t); 0 R'].
  const Eigen::Matrix3d r = rotation_.matrix().transpose();
  const Eigen::Matrix3d diagonal = J.topLeftCorner<3, 3>() * r;
  return upper(diagonal, J.topRightCorner<3, 3>() * r - diagonal * hat(translation_));
}

SE3::Jacobian SE3::right_jacobian(const Tangent& v) {
  const Eigen::Vector3d w = v.tail<3>();
  const detail::RightJacobian j(w.squaredNorm());
  return upper(detail::rotation_polynomial(w, j.f.value, j.g.value),
               detail::rotation_polynomial_derivative(w, v.head<3>(), j.f, j.g));
}

SE3::Jacobian SE3::right_jacobian_inverse(const Tangent& v) {
  const double s = v.tail<3>().squaredNorm();
  return inverse_jacobian(v, detail::cot_coefficient(s, 1.0 / std::tan(0.5 * std::sqrt(s))));
}

}  // namespace hybrid
