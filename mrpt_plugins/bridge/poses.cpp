// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/bridge/poses.h"

#include <cmath>

#include "libhybrid/geometry/uncertain_motion.h"
#include "mrpt_plugins/bridge/pose_conversions.h"

namespace hybrid {
namespace {

Eigen::Matrix3d rotation(const mrpt::poses::CPose3D& T) {
  return T.getRotationMatrix().asEigen();
}

/// Body-frame rotation vector per change of (yaw, pitch, roll), R = Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Matrix3d body_rates(const mrpt::poses::CPose3D& T) {
  const double sp = std::sin(T.pitch()), cp = std::cos(T.pitch());
  const double sr = std::sin(T.roll()), cr = std::cos(T.roll());
  Eigen::Matrix3d E;
  E << -sp, 0, 1,      //
      cp * sr, cr, 0,  //
      cp * cr, -sr, 0;
  return E;
}

Matrix6d block_diagonal(const Eigen::Matrix3d& A, const Eigen::Matrix3d& B) {
  Matrix6d J = Matrix6d::Zero();
  J.topLeftCorner<3, 3>() = A;
  J.bottomRightCorner<3, 3>() = B;
  return J;
}

}  // namespace

Matrix6d tangent_from_euler(const mrpt::poses::CPose3D& T) {
  return block_diagonal(rotation(T).transpose(), body_rates(T));
}

Matrix6d euler_from_tangent(const mrpt::poses::CPose3D& T) {
  return block_diagonal(rotation(T), body_rates(T).inverse());
}

Matrix6d adjoint(const mrpt::poses::CPose3D& T) {
  return adjoint(to_isometry(T));
}

bool is_rotation(const mrpt::poses::CPose3D& T) {
  constexpr double kTolerance = 1e-5;
  const Eigen::Matrix3d R = rotation(T);
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kTolerance &&
         R.determinant() > 0;
}

Matrix6d tangent_covariance(const mrpt::poses::CPose3DPDFGaussian& pdf) {
  const Matrix6d J = tangent_from_euler(pdf.mean);
  return J * pdf.cov.asEigen() * J.transpose();
}

Eigen::Matrix3d tangent_covariance(const mrpt::poses::CPosePDFGaussian& pdf) {
  Eigen::Matrix3d J = Eigen::Matrix3d::Identity();
  J.topLeftCorner<2, 2>() = Eigen::Rotation2Dd(-pdf.mean.phi()).toRotationMatrix();
  return J * pdf.cov.asEigen() * J.transpose();
}

Matrix6d planar_to_6d(const Eigen::Matrix3d& covariance) {
  Matrix6d full = Matrix6d::Zero();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) full(kPlanarIndices[i], kPlanarIndices[j]) = covariance(i, j);
  }
  return full;
}

Eigen::Matrix3d planar_part(const Matrix6d& covariance) {
  Eigen::Matrix3d part;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) part(i, j) = covariance(kPlanarIndices[i], kPlanarIndices[j]);
  }
  return part;
}

Matrix6d usual_motion_covariance(double length, double turn) {
  constexpr double kOfMotion = 0.05;                                  // shares of the motion
  constexpr double kLeastTranslation = 0.02, kLeastRotation = 0.005;  // m, rad
  return isotropic_covariance(kLeastTranslation + kOfMotion * length,
                              kLeastRotation + kOfMotion * turn);
}

mrpt::poses::CPose3DPDFGaussian pose_pdf(const mrpt::poses::CPose3D& mean,
                                         const Matrix6d& covariance) {
  const Matrix6d J = euler_from_tangent(mean);
  return {mean, mrpt::math::CMatrixDouble66(Matrix6d(J * covariance * J.transpose()))};
}

}  // namespace hybrid
