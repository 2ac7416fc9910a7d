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

/// The motion of a log, if it tells any.
std::optional<OdometryIncrement> odometry_of(const LoggedMotion& motion);

/// MRPT's Gaussian motion model, which gives covariances to odometry that carries none.
using MotionModel = mrpt::obs::CActionRobotMovement2D::TMotionModelOptions::TOptions_GaussianModel;
OdometryIncrement odometry_between(const mrpt::poses::CPose2D& before,
                                   const mrpt::poses::CPose2D& after, const MotionModel& model);

/// Whether mean and covariance are finite, the rotation is one, and the covariance has no negative
/// eigenvalue.
bool is_sane(const OdometryIncrement& odometry);

/// Whether a motion may be true of a robot that comes `reach` metres far at most: it does not lead
/// farther, and its sigmas are below that and half a turn, so that it tells something.
bool is_plausible(const OdometryIncrement& odometry, double reach);

/// Adds 1e-10 (a sigma of 1e-5 m or rad) to the diagonal if a direction has no noise at all, since
/// a certain motion has no finite information; returns whether it did.
bool add_noise_floor(OdometryIncrement& odometry);

}  // namespace hybrid
