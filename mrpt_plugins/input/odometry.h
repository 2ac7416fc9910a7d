// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/poses/CPose2D.h>

#include <optional>

#include "mrpt_plugins/bridge/poses.h"
#include "mrpt_plugins/rawlog/log_object.h"

namespace HYBRID_API hybrid {

/// A motion of the robot, T_before_after, and its covariance in the tangent (translation, rotation)
/// of a right perturbation [m, rad]. A planar motion has covariance only at kPlanarIndices.
struct OdometryIncrement {
  mrpt::poses::CPose3D mean;
  Matrix6d covariance = Matrix6d::Zero();
  bool is_planar = true;
};

/// `first` followed by `second`, covariances propagated to first order; planar if both are.
OdometryIncrement compose(const OdometryIncrement& first, const OdometryIncrement& second);

/// The motion of a logged action, if it has any.
std::optional<OdometryIncrement> odometry_of(const LoggedMotion& motion);

/// MRPT's Gaussian motion model, for odometry without a covariance.
using MotionModel = mrpt::obs::CActionRobotMovement2D::TMotionModelOptions::TOptions_GaussianModel;
OdometryIncrement odometry_between(const mrpt::poses::CPose2D& before,
                                   const mrpt::poses::CPose2D& after, const MotionModel& model);
/// The same in space; heights and tilts have the noise of the plane.
OdometryIncrement odometry_between(const mrpt::poses::CPose3D& before,
                                   const mrpt::poses::CPose3D& after, const MotionModel& model);

/// Whether mean and covariance are finite, the rotation is a rotation, and the covariance has no
/// negative eigenvalue.
bool is_sane(const OdometryIncrement& odometry);

/// Whether a motion is plausible for a robot that moves `reach` metres at most: its length and its
/// translational sigmas are at most `reach`, its rotational sigmas at most half a turn.
bool is_plausible(const OdometryIncrement& odometry, double reach);

/// Adds 1e-10 (a sigma of 1e-5 m or rad) to the diagonal if a direction has no noise, since its
/// information would be infinite; returns whether it did.
bool add_noise_floor(OdometryIncrement& odometry);

}  // namespace hybrid
