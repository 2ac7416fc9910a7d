// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/geometry/polar.h"

#include <algorithm>
#include <cmath>

namespace hybrid {

Eigen::Vector2d to_polar(const Eigen::Vector2d& p, Eigen::Matrix2d* J) {
  const double range = p.norm();
  if (J != nullptr) {
    const double inverse = 1.0 / std::max(range, kMinDistance);
    const Eigen::Vector2d u = range > 0.0 ? Eigen::Vector2d(p / range) : Eigen::Vector2d(1.0, 0.0);
    *J << u.x(), u.y(), -inverse * u.y(), inverse * u.x();
  }
  return {range, std::atan2(p.y(), p.x())};
}

Eigen::Vector3d to_polar(const Eigen::Vector3d& p, Eigen::Matrix3d* J) {
  const double rho2 = p.x() * p.x() + p.y() * p.y();
  const double rho = std::sqrt(rho2);
  const double range = std::sqrt(rho2 + p.z() * p.z());
  if (J != nullptr) {
    const double inverse = 1.0 / std::max(range, kMinDistance);
    const double inverse_rho = 1.0 / std::max(rho, kMinDistance);
    const double cos_yaw = rho > 0.0 ? p.x() / rho : 1.0;
    const double sin_yaw = rho > 0.0 ? p.y() / rho : 0.0;
    const Eigen::Vector3d u =
        range > 0.0 ? Eigen::Vector3d(p / range) : Eigen::Vector3d(1.0, 0.0, 0.0);
    const double climb = inverse * u.z();
    *J << u.x(), u.y(), u.z(),                               //
        -inverse_rho * sin_yaw, inverse_rho * cos_yaw, 0.0,  //
        climb * cos_yaw, climb * sin_yaw, -inverse * (range > 0.0 ? rho / range : 1.0);
  }
  return {range, std::atan2(p.y(), p.x()), -std::atan2(p.z(), rho)};
}

Eigen::Vector2d from_polar(const Eigen::Vector2d& z, Eigen::Matrix2d* J) {
  const double c = std::cos(z[1]);
  const double s = std::sin(z[1]);
  if (J != nullptr) *J << c, -z[0] * s, s, z[0] * c;
  return {z[0] * c, z[0] * s};
}

Eigen::Vector3d from_polar(const Eigen::Vector3d& z, Eigen::Matrix3d* J) {
  const double cy = std::cos(z[1]);
  const double sy = std::sin(z[1]);
  const double cp = std::cos(z[2]);
  const double sp = std::sin(z[2]);
  if (J != nullptr) {
    *J << cp * cy, -z[0] * cp * sy, -z[0] * sp * cy,  //
        cp * sy, z[0] * cp * cy, -z[0] * sp * sy,     //
        -sp, 0.0, -z[0] * cp;
  }
  return {z[0] * cp * cy, z[0] * cp * sy, -z[0] * sp};
}

}  // namespace hybrid
