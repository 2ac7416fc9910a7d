// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "libhybrid/registration/alignment.h"

namespace HYBRID_API hybrid {

/// A motion of the source that the matches do not determine, in the frame of the target.
struct FreeMotion {
  bool is_rotation = false;
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< of the translation or of the axis, unit
  Eigen::Vector3d through = Eigen::Vector3d::Zero();    ///< a point on the axis of a rotation
};

/// "rotation about the axis (0, 0, 1) through (1, 2, 3)" or "translation along (1, 0, 0)".
std::string to_string(const FreeMotion& motion);

/// Motions that the matched pairs do not determine: eigenvectors of the information matrix of their
/// well-measured directions, with eigenvalues that errors of these directions explain. `radius` is
/// the size of the source, by which rotations are compared with translations, `spacing` that of the
/// target points.
std::vector<FreeMotion> free_motions(const Alignment& alignment, const SE3& T_target_source,
                                     const Eigen::Vector3d& center, double radius, double spacing);

/// Inverse information of the pairs in the tangent of T_target_source (eq. 14).
Alignment::Matrix6 covariance_of(const Alignment& alignment, const SE3& T_target_source,
                                 const Eigen::Vector3d& center);

}  // namespace hybrid
