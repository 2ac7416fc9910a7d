// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DPDFGaussian.h>
#include <mrpt/poses/CPosePDFGaussian.h>

#include <Eigen/Dense>
#include <array>

#include "libhybrid/geometry/eigen.h"

/// MRPT orders a 3-D pose (x y z yaw pitch roll) with additive errors; here errors live in the
/// tangent space (translation, rotation vector) of a right perturbation T * Exp(xi).
namespace HYBRID_API hybrid {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// Rows and columns of a 6x6 tangent covariance that a planar motion uses: x, y, rotation about z.
inline constexpr std::array<int, 3> kPlanarIndices{0, 1, 5};

/// d xi / d (x y z yaw pitch roll) at T, 6x6; exists everywhere.
Matrix6d tangent_from_euler(const mrpt::poses::CPose3D& T);

/// d (x y z yaw pitch roll) / d xi at T, 6x6; grows without bound as pitch nears +-90 degrees.
Matrix6d euler_from_tangent(const mrpt::poses::CPose3D& T);

/// Adjoint of T for tangents (translation, rotation): T Exp(xi) = Exp(Ad xi) T.
Matrix6d adjoint(const mrpt::poses::CPose3D& T);

/// Whether the rotation matrix of T is a rotation within 1e-5, the single precision of old logs.
bool is_rotation(const mrpt::poses::CPose3D& T);

/// Covariance of xi, to first order.
Matrix6d tangent_covariance(const mrpt::poses::CPose3DPDFGaussian& pdf);

/// Covariance of (x, y, angle) in the moving frame: T * Exp(xi) in SE(2), to first order.
Eigen::Matrix3d tangent_covariance(const mrpt::poses::CPosePDFGaussian& pdf);

/// A planar 3x3 tangent covariance placed into 6x6 at kPlanarIndices, zero elsewhere.
Matrix6d planar_to_6d(const Eigen::Matrix3d& covariance);

/// The entries at kPlanarIndices.
Eigen::Matrix3d planar_part(const Matrix6d& covariance);

/// Covariance of a motion by odometry whose errors nobody states, by its length [m] and turn [rad],
/// in the tangent.
Matrix6d usual_motion_covariance(double length, double turn);

/// The Gaussian over MRPT's coordinates of a tangent covariance: the inverse of
/// tangent_covariance().
mrpt::poses::CPose3DPDFGaussian pose_pdf(const mrpt::poses::CPose3D& mean,
                                         const Matrix6d& covariance);

}  // namespace hybrid
