// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/geometry/se2.h"

#include <cmath>

namespace hybrid {
namespace {

constexpr double kSmallAngle = 1e-4;

double sinc(double t) {
  return std::abs(t) < kSmallAngle ? 1.0 - t * t / 6.0 : std::sin(t) / t;
}

/// (1 - cos t) / t.
double cosc(double t) {
  return std::abs(t) < kSmallAngle ? t / 2.0 - t * t * t / 24.0 : (1.0 - std::cos(t)) / t;
}

/// (t / 2) cot(t / 2), even in t and 1 at zero, given the cosine and sine of t.
double half_cot(double t, double c, double s) {
  if (std::abs(t) < kSmallAngle) return 1.0 - t * t / 12.0;
  return 0.5 * t * (c > 0.0 ? (1.0 + c) / s : s / (1.0 - c));
}

/// (t - sin t) / t^2 and (1 - cos t) / t^2 as they enter the right Jacobian.
double sin_remainder(double t, double s) {
  if (std::abs(t) < 1e-2) return t / 6.0 - t * t * t / 120.0 + t * t * t * t * t / 5040.0;
  return (t - s) / (t * t);
}
double cos_remainder(double t, double c) {
  if (std::abs(t) < 1e-2) return 0.5 - t * t / 24.0 + t * t * t * t / 720.0;
  return (1.0 - c) / (t * t);
}

/// The inverse of the right Jacobian at v, given the cosine and sine of its angle: the rotation
/// block [a b; -b a] has the inverse [h -t/2; t/2 h] with h = (t/2) cot(t/2).
SE2::Jacobian inverse_jacobian(const SE2::Tangent& v, double h, double c, double s) {
  const double k = 0.5 * v[2];
  const double p = sin_remainder(v[2], s);
  const double q = cos_remainder(v[2], c);
  const double cx = p * v[0] - q * v[1];
  const double cy = q * v[0] + p * v[1];
  SE2::Jacobian m;
  m << h, -k, -(h * cx - k * cy),  //
      k, h, -(k * cx + h * cy),    //
      0.0, 0.0, 1.0;
  return m;
}

}  // namespace

Eigen::Matrix3d SE2::matrix() const {
  Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
  m.topLeftCorner<2, 2>() = rotation_.matrix();
  m.topRightCorner<2, 1>() = translation_;
  return m;
}

SE2 SE2::exp(const Tangent& v) {
  const double a = sinc(v[2]);
  const double b = cosc(v[2]);
  return {{a * v[0] - b * v[1], b * v[0] + a * v[1]}, SO2(v[2])};
}

SE2::Tangent SE2::log(Jacobian* inverse) const {
  const double t = rotation_.angle();
  const double a = half_cot(t, rotation_.cos(), rotation_.sin());
  const double b = 0.5 * t;
  const Tangent v(a * x() + b * y(), -b * x() + a * y(), t);
  if (inverse != nullptr) *inverse = inverse_jacobian(v, a, rotation_.cos(), rotation_.sin());
  return v;
}

SE2::Jacobian SE2::adjoint() const {
  Jacobian m;
  m << rotation_.cos(), -rotation_.sin(), y(),  //
      rotation_.sin(), rotation_.cos(), -x(),   //
      0.0, 0.0, 1.0;
  return m;
}

SE2::Jacobian SE2::right_jacobian(const Tangent& v) {
  const double a = sinc(v[2]);
  const double b = cosc(v[2]);
  const double p = sin_remainder(v[2], std::sin(v[2]));
  const double q = cos_remainder(v[2], std::cos(v[2]));
  Jacobian m;
  m << a, b, p * v[0] - q * v[1],  //
      -b, a, q * v[0] + p * v[1],  //
      0.0, 0.0, 1.0;
  return m;
}

SE2::Jacobian SE2::right_jacobian_inverse(const Tangent& v) {
  const double c = std::cos(v[2]);
  const double s = std::sin(v[2]);
  return inverse_jacobian(v, half_cot(v[2], c, s), c, s);
}

}  // namespace hybrid
