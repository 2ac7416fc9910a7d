// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/geometry/se3.h"

#include <cmath>

namespace hybrid {
namespace {

/// The block of the SE(3) right Jacobian that couples rotation into translation (Barfoot, State
/// Estimation for Robotics, sec. 7.1.5, at the negated tangent).
Eigen::Matrix3d coupling(const SE3::Tangent& v) {
  const Eigen::Matrix3d p = hat(-v.head<3>());
  const Eigen::Matrix3d r = hat(-v.tail<3>());
  const double t2 = v.tail<3>().squaredNorm();
  const double t = std::sqrt(t2);
  double a, b, c;  // the three remainders of sine and cosine; series where they would cancel
  if (t < 0.5) {
    a = 1.0 / 6 - t2 * (1.0 / 120 - t2 * (1.0 / 5040 - t2 * (1.0 / 362880 - t2 / 39916800.0)));
    b = 1.0 / 24 - t2 * (1.0 / 720 - t2 * (1.0 / 40320 - t2 * (1.0 / 3628800 - t2 / 479001600.0)));
    c = 1.0 / 120 -
        t2 * (1.0 / 5040 - t2 * (1.0 / 362880 - t2 * (1.0 / 39916800 - t2 / 6227020800.0)));
  } else {
    a = (t - std::sin(t)) / (t2 * t);
    b = (std::cos(t) - 1.0 + 0.5 * t2) / (t2 * t2);
    c = (std::sin(t) - t + t2 * t / 6.0) / (t2 * t2 * t);
  }
  const Eigen::Matrix3d rp = r * p;
  const Eigen::Matrix3d pr = p * r;
  const Eigen::Matrix3d rpr = rp * r;
  return 0.5 * p + a * (rp + pr + rpr) + b * (r * rp + pr * r - 3.0 * rpr) +
         0.5 * (b - 3.0 * c) * (rpr * r + r * rpr);
}

}  // namespace

Eigen::Matrix4d SE3::matrix() const {
  Eigen::Matrix4d m = Eigen::Matrix4d::Identity();
  m.topLeftCorner<3, 3>() = rotation_.matrix();
  m.topRightCorner<3, 1>() = translation_;
  return m;
}

SE3 SE3::exp(const Tangent& v) {
  // The left Jacobian is the right one at the negated tangent.
  return {SO3::right_jacobian(-v.tail<3>()) * v.head<3>(), SO3::exp(v.tail<3>())};
}

SE3::Tangent SE3::log() const {
  const Eigen::Vector3d w = rotation_.log();
  Tangent v;
  v << SO3::right_jacobian_inverse(-w) * translation_, w;
  return v;
}

SE3::Jacobian SE3::adjoint() const {
  const Eigen::Matrix3d r = rotation_.matrix();
  Jacobian m;
  m << r, hat(translation_) * r, Eigen::Matrix3d::Zero(), r;
  return m;
}

SE3::Jacobian SE3::right_jacobian(const Tangent& v) {
  const Eigen::Matrix3d j = SO3::right_jacobian(v.tail<3>());
  Jacobian m;
  m << j, coupling(v), Eigen::Matrix3d::Zero(), j;
  return m;
}

SE3::Jacobian SE3::right_jacobian_inverse(const Tangent& v) {
  const Eigen::Matrix3d j = SO3::right_jacobian_inverse(v.tail<3>());
  Jacobian m;
  m << j, -j * coupling(v) * j, Eigen::Matrix3d::Zero(), j;
  return m;
}

}  // namespace hybrid
