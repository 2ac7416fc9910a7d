// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/registration/detail/starts.h"

#include <cmath>

namespace hybrid {
namespace {

constexpr double kTurn = 35.0 * M_PI / 180.0;

/// The axes of a cube's faces and corners, both ways.
std::vector<Eigen::Vector3d> directions() {
  std::vector<Eigen::Vector3d> all;
  for (int x = -1; x <= 1; ++x) {
    for (int y = -1; y <= 1; ++y) {
      for (int z = -1; z <= 1; ++z) {
        const Eigen::Vector3d d(x, y, z);
        if (d.squaredNorm() == 1.0 || d.squaredNorm() == 3.0) all.push_back(d.normalized());
      }
    }
  }
  return all;
}

SE3 turned(const SE3& T_target_source, const Eigen::Vector3d& rotation,
           const Eigen::Vector3d& source_center, const Eigen::Vector3d& center) {
  const SO3 R = SO3::exp(rotation) * T_target_source.rotation();
  return {center - R * source_center, R};
}

}  // namespace

std::vector<SE3> other_starts(const SE3& T_target_source, const Eigen::Vector3d& source_center,
                              const Eigen::Vector3d& target_center) {
  std::vector<SE3> starts;
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  starts.push_back(turned(T_target_source, zero, source_center, target_center));
  for (const Eigen::Vector3d& d : directions()) {
    for (const Eigen::Vector3d& center : {T_target_source * source_center, target_center}) {
      starts.push_back(turned(T_target_source, kTurn * d, source_center, center));
    }
  }
  return starts;
}

}  // namespace hybrid
