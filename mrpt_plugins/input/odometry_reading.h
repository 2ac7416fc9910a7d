// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose2D.h>
#include <mrpt/poses/CPose3D.h>

#include <optional>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// A pose by odometry, in space where it is not in the plane.
struct OdometryReading {
  mrpt::poses::CPose2D plane;
  std::optional<mrpt::poses::CPose3D> space;

  Eigen::Vector3d position() const;
  mrpt::poses::CPose3D in_space() const { return space.value_or(mrpt::poses::CPose3D(plane)); }
  Eigen::Isometry3d isometry() const;
};

/// Whether a pose is in the plane, up to rounding.
bool is_planar(const mrpt::poses::CPose3D& pose);

/// The pose at a share of the way from one to another.
OdometryReading between(const OdometryReading& a, const OdometryReading& b, double fraction);

}  // namespace hybrid
