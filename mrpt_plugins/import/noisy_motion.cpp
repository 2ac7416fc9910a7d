// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/import/noisy_motion.h"

#include <algorithm>

#include "mrpt_plugins/import/log_writer.h"

namespace hybrid {

OdometryIncrement noisy_motion(const mrpt::poses::CPose3D& motion, const MotionNoise& noise,
                               bool is_3d, Random& random) {
  constexpr double kLeast = 1e-5;  // keeps the information finite for motions without noise
  const double t = noise.translation, r = noise.rotation;
  const double vt = std::max(t, kLeast) * std::max(t, kLeast);
  const double vr = std::max(r, kLeast) * std::max(r, kLeast);
  if (!is_3d) {
    const double x = random.normal(t), y = random.normal(t), angle = random.normal(r);
    const mrpt::poses::CPose3D mean = motion + mrpt::poses::CPose3D(x, y, 0, angle, 0, 0);
    return planar_motion(mean.x(), mean.y(), mean.yaw(), Eigen::Vector3d(vt, vt, vr).asDiagonal());
  }
  const double x = random.normal(t), y = random.normal(t), z = random.normal(t);
  const double yaw = random.normal(r), pitch = random.normal(r), roll = random.normal(r);
  Eigen::Matrix<double, 6, 1> variances;
  variances << vt, vt, vt, vr, vr, vr;
  return {motion + mrpt::poses::CPose3D(x, y, z, yaw, pitch, roll), variances.asDiagonal(), false};
}

}  // namespace hybrid
