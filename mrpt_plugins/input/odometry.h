// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/poses/CPose2D.h>

#include <optional>

#include "mrpt_plugins/bridge/poses.h"

namespace hybrid {

/// A motion of the robot, T_before_after, and its covariance in the tangent (translation, rotation)
/// of a right perturbation [m, rad]. A planar motion has covariance only at kPlanarIndices.
struct OdometryIncrement {
  mrpt::poses::CPose3D mean;
  Matrix6d covariance = Matrix6d::Zero();
  bool is_planar = true;
};

/// `first` followed by `second`, covariances propagated to first order; planar if both are.
OdometryIncrement compose(const OdometryIncrement& first, const OdometryIncrement& second);

/// The motion in a collection of actions: CActionRobotMovement3D or else 2D, nothing if neither.
/// MRPT's 2-D particle or grid forms are taken by mean and covariance.
std::optional<OdometryIncrement> odometry_of(const mrpt::obs::CActionCollection& actions);

/// MRPT's Gaussian motion model, which gives covariances to odometry that carries none.
using MotionModel = mrpt::obs::CActionRobotMovement2D::TMotionModelOptions::TOptions_GaussianModel;
OdometryIncrement odometry_between(const mrpt::poses::CPose2D& before,
                                   const mrpt::poses::CPose2D& after, const MotionModel& model);

/// Whether mean and covariance are finite and the covariance has no negative eigenvalue.
bool is_sane(const OdometryIncrement& odometry);

/// Adds 1e-10 (a sigma of 1e-5 m or rad) to the diagonal if a direction has no noise at all, since
/// a certain motion has no finite information; returns whether it did.
bool add_noise_floor(OdometryIncrement& odometry);

}  // namespace hybrid
