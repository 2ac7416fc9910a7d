// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/motion.h"

#include <fmt/format.h>

#include <memory>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/calibrated_motion.h"
#include "libhybrid/factors/prior.h"
#include "mrpt_plugins/mapping/space.h"

namespace hybrid {
namespace {

Eigen::VectorXd two_sigmas(double sigma_m, double sigma_rad, bool is_3d) {
  Eigen::VectorXd sigmas(is_3d ? 6 : 3);
  sigmas.setConstant(sigma_rad);
  sigmas.head(is_3d ? 3 : 2).setConstant(sigma_m);
  return sigmas;
}

bool stands_still(const OdometryIncrement& odometry) {
  return odometry.mean.norm() == 0.0 && odometry.mean.getRotationMatrix().asEigen().isIdentity(0.0);
}

Noise odometry_noise(const OdometryIncrement& odometry, const MotionOptions& options, bool is_3d) {
  if (options.standstill_sigma_m > 0 && stands_still(odometry)) {
    return Noise::diagonal(
        two_sigmas(options.standstill_sigma_m, options.standstill_sigma_rad, is_3d));
  }
  const std::vector<double>& s = options.odometry_sigmas;
  if (!s.empty()) {
    return Noise::diagonal(
        Eigen::Map<const Eigen::VectorXd>(s.data(), static_cast<Eigen::Index>(s.size())));
  }
  if (is_3d) return Noise::covariance(odometry.covariance);
  return Noise::covariance(planar_part(odometry.covariance));
}

}  // namespace

MotionOptions read_motion_options(IniFile& ini) {
  MotionOptions options;
  IniSection odometry = ini.section("odometry", "Noise of the motion from keyframe to keyframe");
  options.odometry_sigmas = odometry.get(
      "sigmas", options.odometry_sigmas,
      "standard deviations of x y angle, or in space of x y z and the rotation vector [m, rad], in "
      "the frame of the robot; empty: the covariance in the log",
      kPositive);
  options.standstill_sigma_m = odometry.get(
      "standstill_sigma_m", options.standstill_sigma_m,
      "where odometry says exactly no motion, as wheels at rest do, its noise [m]; 0: as any",
      kNonNegative);
  options.standstill_sigma_rad =
      odometry.degrees("standstill_sigma_deg", 0.001, "the same for the rotation", kPositive);
  options.lost_sigma_m = odometry.get(
      "lost_sigma_m", options.lost_sigma_m,
      "where odometry is missing, the robot is taken to stand still with this sigma", kPositive);
  options.lost_sigma_rad =
      odometry.degrees("lost_sigma_deg", 30.0, "the same for the rotation", kPositive);
  IniSection prior = ini.section("prior", "The first pose, which is the origin of the map");
  options.prior_sigma_m =
      prior.get("sigma_m", options.prior_sigma_m, "of its position [m]", kPositive);
  options.prior_sigma_rad =
      prior.get("sigma_rad", options.prior_sigma_rad, "of its rotation [rad]", kPositive);
  return options;
}

void check(const MotionOptions& options, bool is_3d) {
  const std::size_t wanted = is_3d ? 6 : 3, given = options.odometry_sigmas.size();
  if (given == 0 || given == wanted) return;
  throw Error(fmt::format("[odometry] sigmas has {} numbers, but the map is {}: give {} or none",
                          given, is_3d ? "in space" : "in the plane", wanted));
}

ContinuousFactorPtr origin_factor(Key pose, const MotionOptions& options, bool is_3d) {
  const Noise noise =
      Noise::diagonal(two_sigmas(options.prior_sigma_m, options.prior_sigma_rad, is_3d));
  if (is_3d) return std::make_shared<Prior<SE3>>(pose, SE3(), noise);
  return std::make_shared<Prior<SE2>>(pose, SE2(), noise);
}

ContinuousFactorPtr odometry_factor(Key a, Key b, OdometryIncrement odometry,
                                    const MotionOptions& options, bool is_3d,
                                    const std::optional<Key>& calibration) {
  if (is_3d && odometry.is_planar) {
    odometry.is_planar = false;
    add_noise_floor(odometry);
  }
  const Noise noise = odometry_noise(odometry, options, is_3d);
  if (calibration && is_3d) {
    return std::make_shared<CalibratedMotion3>(a, b, *calibration, to_se3(odometry.mean), noise);
  }
  if (calibration) {
    return std::make_shared<CalibratedMotion2>(a, b, *calibration, to_se2(odometry.mean), noise);
  }
  if (is_3d) return std::make_shared<Between<SE3>>(a, b, to_se3(odometry.mean), noise);
  return std::make_shared<BetweenSE2>(a, b, to_se2(odometry.mean), noise);
}

OdometryIncrement unknown_motion(const MotionOptions& options, bool is_3d) {
  OdometryIncrement motion;
  motion.is_planar = !is_3d;
  const Eigen::VectorXd variances =
      two_sigmas(options.lost_sigma_m, options.lost_sigma_rad, true).array().square();
  motion.covariance = variances.asDiagonal();
  return motion;
}

}  // namespace hybrid
