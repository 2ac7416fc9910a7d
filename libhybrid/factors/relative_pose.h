// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <optional>
#include <type_traits>

#include "libhybrid/factors/factor.h"

namespace HYBRID_API hybrid {

/// The motion that a factor measures, and its information matrix over the tangent at it.
template <class Pose>
RelativePose<Pose> relative_pose_of(const Pose& measured,
                                    const typename Pose::Jacobian& sqrt_information) {
  return {measured, sqrt_information.transpose() * sqrt_information};
}

/// ContinuousFactor::relative_pose_2d or _3d.
template <class Pose>
std::optional<RelativePose<Pose>> relative_pose(const ContinuousFactor& factor) {
  if constexpr (std::is_same_v<Pose, SE2>) {
    return factor.relative_pose_2d();
  } else {
    return factor.relative_pose_3d();
  }
}

}  // namespace hybrid
