// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/odometry_reading.h"

#include <mrpt/math/wrap2pi.h>

#include <cmath>

#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

using mrpt::poses::CPose2D;
using mrpt::poses::CPose3D;

CPose2D between(const CPose2D& a, const CPose2D& b, double fraction) {
  const CPose2D step = b - a;
  return a + CPose2D(fraction * step.x(), fraction * step.y(), fraction * step.phi());
}

CPose3D between(const CPose3D& a, const CPose3D& b, double fraction) {
  const CPose3D step = b - a;
  const auto part = [&](double angle) { return fraction * mrpt::math::wrapToPi(angle); };
  return a + CPose3D(fraction * step.x(), fraction * step.y(), fraction * step.z(),
                     part(step.yaw()), part(step.pitch()), part(step.roll()));
}

}  // namespace

Eigen::Vector3d OdometryReading::position() const {
  if (space) return {space->x(), space->y(), space->z()};
  return {plane.x(), plane.y(), 0};
}

Eigen::Isometry3d OdometryReading::isometry() const {
  return to_isometry(in_space());
}

bool is_planar(const CPose3D& pose) {
  constexpr double kDigits = 1e-6;
  return std::abs(pose.z()) < kDigits && std::abs(pose.pitch()) < kDigits &&
         std::abs(pose.roll()) < kDigits;
}

OdometryReading between(const OdometryReading& a, const OdometryReading& b, double fraction) {
  OdometryReading out{between(a.plane, b.plane, fraction), std::nullopt};
  if (b.space) out.space = between(a.in_space(), *b.space, fraction);
  return out;
}

}  // namespace hybrid
