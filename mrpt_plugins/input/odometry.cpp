// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/odometry.h"

#include <mrpt/poses/CPosePDFGaussian.h>

#include <algorithm>
#include <cmath>

namespace hybrid {
namespace {

constexpr double kVarianceFloor = 1e-12;
constexpr double kAddedVariance = 1e-10;

OdometryIncrement planar_increment(const mrpt::poses::CPosePDFGaussian& pdf) {
  return {mrpt::poses::CPose3D(pdf.mean), planar_to_6d(tangent_covariance(pdf)), true};
}

double smallest_eigenvalue(const OdometryIncrement& odometry) {
  if (odometry.is_planar) {
    return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(planar_part(odometry.covariance),
                                                          Eigen::EigenvaluesOnly)
        .eigenvalues()[0];
  }
  return Eigen::SelfAdjointEigenSolver<Matrix6d>(odometry.covariance, Eigen::EigenvaluesOnly)
      .eigenvalues()[0];
}

}  // namespace

OdometryIncrement compose(const OdometryIncrement& first, const OdometryIncrement& second) {
  const Matrix6d Ad = adjoint(-second.mean);
  return {first.mean + second.mean, Ad * first.covariance * Ad.transpose() + second.covariance,
          first.is_planar && second.is_planar};
}

std::optional<OdometryIncrement> odometry_of(const LoggedMotion& motion) {
  if (const auto* plane = std::get_if<mrpt::poses::CPosePDFGaussian>(&motion)) {
    return planar_increment(*plane);
  }
  if (const auto* space = std::get_if<mrpt::poses::CPose3DPDFGaussian>(&motion)) {
    return OdometryIncrement{space->mean, tangent_covariance(*space), false};
  }
  return std::nullopt;
}

OdometryIncrement odometry_between(const mrpt::poses::CPose2D& before,
                                   const mrpt::poses::CPose2D& after, const MotionModel& model) {
  mrpt::obs::CActionRobotMovement2D::TMotionModelOptions options;
  options.modelSelection = mrpt::obs::CActionRobotMovement2D::mmGaussian;
  options.gaussianModel = model;
  mrpt::obs::CActionRobotMovement2D action;
  action.computeFromOdometry(after - before, options);
  const auto [covariance, mean] = action.poseChange->getCovarianceAndMean();
  return planar_increment({mean, covariance});
}

OdometryIncrement odometry_between(const mrpt::poses::CPose3D& before,
                                   const mrpt::poses::CPose3D& after, const MotionModel& model) {
  const mrpt::poses::CPose3D mean = after - before;
  const double angle =
      std::acos(std::clamp((mean.getRotationMatrix().asEigen().trace() - 1) / 2, -1.0, 1.0));
  // The plane's motion of the same length and angle tells the sigmas.
  const OdometryIncrement plane =
      odometry_between(mrpt::poses::CPose2D(), {mean.norm(), 0, angle}, model);
  Eigen::Matrix<double, 6, 1> variances;
  variances.head<3>().setConstant(plane.covariance.diagonal().head<2>().maxCoeff());
  variances.tail<3>().setConstant(plane.covariance(5, 5));
  return {mean, variances.asDiagonal(), false};
}

bool is_sane(const OdometryIncrement& odometry) {
  const auto& T = odometry.mean;
  const Eigen::Matrix<double, 6, 1> values(
      (Eigen::Matrix<double, 6, 1>() << T.x(), T.y(), T.z(), T.yaw(), T.pitch(), T.roll())
          .finished());
  if (!values.allFinite() || !odometry.covariance.allFinite() || !is_rotation(T)) return false;
  return smallest_eigenvalue(odometry) > -kVarianceFloor * (1 + odometry.covariance.trace());
}

bool is_plausible(const OdometryIncrement& odometry, double reach) {
  const Eigen::Matrix<double, 6, 1> variances = odometry.covariance.diagonal();
  return odometry.mean.norm() <= reach && variances.head<3>().maxCoeff() <= reach * reach &&
         variances.tail<3>().maxCoeff() <= M_PI * M_PI;
}

bool add_noise_floor(OdometryIncrement& odometry) {
  if (smallest_eigenvalue(odometry) >= kVarianceFloor) return false;
  if (odometry.is_planar) {
    for (const int i : kPlanarIndices) odometry.covariance(i, i) += kAddedVariance;
  } else {
    odometry.covariance.diagonal().array() += kAddedVariance;
  }
  return true;
}

}  // namespace hybrid
