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

/// A relation between odometry and motion, such as slip.
struct MotionMode {
  std::string name;
  double share = 1;        ///< motion over measured motion
  double share_sigma = 0;  ///< sigma of the share: noise in proportion to the measured translation
  double sigma_rad = 0;    ///< added noise of the rotation
};

/// Start pose in a known map.
struct KnownStart {
  Eigen::Isometry3d T_map_robot = Eigen::Isometry3d::Identity();
  /// Tangent covariance of a right perturbation, 3x3 in 2-D, 6x6 in 3-D.
  Eigen::MatrixXd covariance;
  /// Whether it is from measurements that the map gets too: Mapper::forget_start gives it up, and
  /// until then its pose stays in the graph.
  bool found = false;
};

/// Motion model. Sigmas are over (x, y, angle) in 2-D and over (x, y, z, rotation vector) in 3-D
/// [m, rad].
struct MotionOptions {
  std::vector<double> odometry_sigmas;  ///< empty: covariances of the log
  double standstill_sigma_m = 0;        ///< of odometry without any motion; 0: no special case
  double standstill_sigma_rad = 0;
  double prior_sigma_m = 1e-6;  ///< of the first pose, which defines the map frame
  double prior_sigma_rad = 1e-6;
  std::optional<KnownStart> start;  ///< replaces the prior above: the map frame is that of a known
                                    ///< map
  double lost_sigma_m = 1.0;        ///< of the zero motion that replaces missing odometry
  double lost_sigma_rad = 0.5;
  /// If positive, sigma of the change of the robot's step between successive keyframes [m].
  double steady_sigma_m = 0;
  /// If there are several, a discrete variable per motion selects its mode, and `chain` has their
  /// transition probabilities (Fig. 1a).
  std::vector<MotionMode> modes;
  MarkovChain chain;
};

/// Reads sections [odometry], [motion] and [prior].
MotionOptions read_motion_options(IniFile& ini);

/// Throws Error unless the sigmas fit the dimension of the map.
void check(const MotionOptions& options, bool is_3d);

/// Prior of the first pose: the origin of the map, or the known start.
ContinuousFactorPtr origin_factor(Key pose, const MotionOptions& options, bool is_3d);

/// The measured motion from pose `a` to pose `b` (eq. 15), corrected by the calibration of the
/// odometry if that is a variable.
ContinuousFactorPtr odometry_factor(Key a, Key b, OdometryIncrement odometry,
                                    const MotionOptions& options, bool is_3d,
                                    const std::optional<Key>& calibration = std::nullopt);

/// The same motion with one of several modes, selected by a discrete variable.
HybridFactorPtr switching_factor(DiscreteKey mode, Key a, Key b, const OdometryIncrement& odometry,
                                 const MotionOptions& options, bool is_3d,
                                 const std::optional<Key>& calibration = std::nullopt);

/// Constant velocity over three successive keyframes.
ContinuousFactorPtr steady_factor(Key a, Key b, Key c, const MotionOptions& options, bool is_3d);

/// Zero motion with the large noise `lost_sigma_*`, which replaces missing odometry.
OdometryIncrement unknown_motion(const MotionOptions& options, bool is_3d);

}  // namespace hybrid
