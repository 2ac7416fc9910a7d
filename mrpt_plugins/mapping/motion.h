// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "libhybrid/factors/factor.h"
#include "libhybrid/hybrid/hybrid_factor.h"
#include "libhybrid/switching/markov.h"
#include "mrpt_plugins/bridge/ini_file.h"
#include "mrpt_plugins/input/odometry.h"

namespace HYBRID_API hybrid {

/// One way in which odometry and motion go together.
struct MotionMode {
  std::string name;
  double share = 1;        ///< of the measured motion that is real
  double share_sigma = 0;  ///< of the share: adds noise in proportion to the measured translation
  double sigma_rad = 0;    ///< added noise of the rotation
};

/// Where a robot starts in a map that there is already.
struct KnownStart {
  Eigen::Isometry3d T_map_robot = Eigen::Isometry3d::Identity();
  /// In the tangent of a right perturbation, 3x3 in the plane or 6x6.
  Eigen::MatrixXd covariance;
};

/// How motion enters the map. Sigmas are over (x, y, angle) for a map in the plane and over (x, y,
/// z, rotation vector) in space [m, rad].
struct MotionOptions {
  std::vector<double> odometry_sigmas;  ///< empty: as the log says
  double standstill_sigma_m = 0;        ///< of odometry that says exactly no motion; 0: as any
  double standstill_sigma_rad = 0;
  double prior_sigma_m = 1e-6;  ///< of the first pose, which defines the map frame
  double prior_sigma_rad = 1e-6;
  std::optional<KnownStart> start;  ///< instead of these: the map frame is that of a map
  double lost_sigma_m = 1.0;        ///< of standing still, assumed where odometry is missing
  double lost_sigma_rad = 0.5;
  /// Where positive, the step of the robot changes by about this much from keyframe to keyframe
  /// [m].
  double steady_sigma_m = 0;
  /// Where there are several, a discrete variable per motion says which one it followed, and
  /// `chain` how they follow each other (Fig. 1a).
  std::vector<MotionMode> modes;
  MarkovChain chain;
};

/// Reads sections [odometry], [motion] and [prior].
MotionOptions read_motion_options(IniFile& ini);

/// Throws Error unless the sigmas fit a map of this dimension.
void check(const MotionOptions& options, bool is_3d);

/// Ties the first pose to the origin of the map.
ContinuousFactorPtr origin_factor(Key pose, const MotionOptions& options, bool is_3d);

/// The measured motion from pose `a` to pose `b` (eq. 15), through the calibration of the odometry
/// where that is a variable.
ContinuousFactorPtr odometry_factor(Key a, Key b, OdometryIncrement odometry,
                                    const MotionOptions& options, bool is_3d,
                                    const std::optional<Key>& calibration = std::nullopt);

/// The same motion by one of several modes, chosen by a discrete variable.
HybridFactorPtr switching_factor(DiscreteKey mode, Key a, Key b, const OdometryIncrement& odometry,
                                 const MotionOptions& options, bool is_3d,
                                 const std::optional<Key>& calibration = std::nullopt);

/// Three keyframes in a row of a robot at steady speed.
ContinuousFactorPtr steady_factor(Key a, Key b, Key c, const MotionOptions& options, bool is_3d);

/// No motion with the wide noise of `lost_sigma_*`: what is assumed where odometry is missing.
OdometryIncrement unknown_motion(const MotionOptions& options, bool is_3d);

}  // namespace hybrid
