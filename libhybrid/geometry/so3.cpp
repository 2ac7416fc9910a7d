// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/geometry/so3.h"

#include <cmath>

namespace hybrid {
namespace {

/// Below this angle the closed forms lose digits to cancellation and the series take over.
constexpr double kSmallAngle = 0.05;

/// (1 - cos t) / t^2 from t^2.
double cos_ratio(double t2) {
  if (t2 < kSmallAngle * kSmallAngle)
    return 0.5 - t2 * (1.0 / 24.0 - t2 * (1.0 / 720.0 - t2 / 40320.0));
  return (1.0 - std::cos(std::sqrt(t2))) / t2;
}

/// (t - sin t) / t^3 from t^2.
double sin_ratio(double t2) {
  if (t2 < kSmallAngle * kSmallAngle) {
    return 1.0 / 6.0 - t2 * (1.0 / 120.0 - t2 * (1.0 / 5040.0 - t2 / 362880.0));
  }
  const double t = std::sqrt(t2);
  return (t - std::sin(t)) / (t2 * t);
}

/// 1 / t^2 - cot(t / 2) / (2 t) from t^2.
double cot_ratio(double t2) {
  if (t2 < kSmallAngle * kSmallAngle) {
    return 1.0 / 12.0 + t2 * (1.0 / 720.0 + t2 * (1.0 / 30240.0 + t2 / 1209600.0));
  }
  const double t = std::sqrt(t2);
  return 1.0 / t2 - std::cos(0.5 * t) / (2.0 * t * std::sin(0.5 * t));
}

}  // namespace

Eigen::Matrix3d hat(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(),  //
      v.z(), 0.0, -v.x(),   //
      -v.y(), v.x(), 0.0;
  return m;
}

SO3 SO3::exp(const Tangent& v) {
  const double t2 = v.squaredNorm();
  const double t = std::sqrt(t2);
  const double k = t < 1e-4 ? 0.5 - t2 / 48.0 : std::sin(0.5 * t) / t;
  const double w = t < 1e-4 ? 1.0 - t2 / 8.0 : std::cos(0.5 * t);
  return SO3(Eigen::Quaterniond(w, k * v.x(), k * v.y(), k * v.z()));
}

SO3::Tangent SO3::log() const {
  const double sign = q_.w() < 0.0 ? -1.0 : 1.0;
  const double w = sign * q_.w();
  const double n2 = q_.vec().squaredNorm();
  const double n = std::sqrt(n2);
  const double k = n < 1e-4 ? 2.0 / w * (1.0 - n2 / (3.0 * w * w)) : 2.0 * std::atan2(n, w) / n;
  return sign * k * q_.vec();
}

SO3::Jacobian SO3::right_jacobian(const Tangent& v) {
  const double t2 = v.squaredNorm();
  const Eigen::Matrix3d h = hat(v);
  return Jacobian::Identity() - cos_ratio(t2) * h + sin_ratio(t2) * h * h;
}

SO3::Jacobian SO3::right_jacobian_inverse(const Tangent& v) {
  const Eigen::Matrix3d h = hat(v);
  return Jacobian::Identity() + 0.5 * h + cot_ratio(v.squaredNorm()) * h * h;
}

}  // namespace hybrid
