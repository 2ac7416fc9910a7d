// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>

#include <cstdint>

#include "mrpt_plugins/input/odometry.h"
#include "mrpt_plugins/simulation/random.h"

namespace HYBRID_API hybrid {

/// Gaussian noise that turns accurate motions into odometry, reproducible by its seed.
struct MotionNoise {
  double translation = 0;  ///< Sigma of each axis per step [m].
  double rotation = 0;     ///< [rad]
  std::uint64_t seed = 1;
};

/// The motion with noise added, and the covariance of the noise. In the plane, only x, y and yaw.
OdometryIncrement noisy_motion(const mrpt::poses::CPose3D& motion, const MotionNoise& noise,
                               bool is_3d, Random& random);

}  // namespace hybrid
