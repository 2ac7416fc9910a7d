// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/motion.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <memory>
#include <utility>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/calibrated_motion.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/steady_motion.h"
#include "libhybrid/hybrid/mixture.h"
#include "mrpt_plugins/bridge/pose_conversions.h"

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

constexpr const char* kTransitionMeaning =
    "row by row (mode before), the probability of each mode after; empty: a mode lasts 20 "
    "keyframes, a second one 5";

/// One number per mode; where none is given that of the `usual` ones, the second of two.
std::vector<double> per_mode(IniSection& s, const std::string& key, std::size_t modes,
                             const std::array<double, 2>& usual, const std::string& meaning,
                             const Interval& range) {
  const auto given = s.get(key, std::vector<double>{}, meaning, range);
  if (given.empty() && modes == 2) return {usual[0], usual[1]};
  if (given.empty()) return std::vector<double>(modes, usual[0]);
  if (given.size() != modes) {
    s.fail(key, fmt::format("has {} numbers for {} modes", given.size(), modes));
  }
  return given;
}

/// The stationary distribution, by repeated transitions.
Eigen::VectorXd stationary(const Eigen::MatrixXd& transition) {
  const auto n = transition.rows();
  Eigen::VectorXd p = Eigen::VectorXd::Constant(n, 1.0 / static_cast<double>(n));
  for (int i = 0; i < 200; ++i) p = 0.5 * (p + transition.transpose() * p);
  return p / p.sum();
}

MarkovChain read_chain(IniSection& s, std::size_t modes) {
  const auto n = static_cast<Eigen::Index>(modes);
  const auto given = s.get("transition", std::vector<double>{}, kTransitionMeaning, kProbability);
  MarkovChain chain = sticky_chain(static_cast<int>(modes), 0.95);
  if (modes == 2) chain.transition.row(1) << 0.2, 0.8;
  if (!given.empty()) {
    if (given.size() != modes * modes) {
      s.fail("transition", fmt::format("needs {} numbers for {} modes", modes * modes, modes));
    }
    for (Eigen::Index i = 0; i < n * n; ++i) {
      chain.transition(i / n, i % n) = given[static_cast<std::size_t>(i)];
    }
  }
  try {
    check(chain);
  } catch (const Error& e) {
    s.fail("transition", std::string("is not that of a Markov chain: ") + e.what());
  }
  chain.initial = stationary(chain.transition);
  return chain;
}

void read_modes(IniFile& ini, MotionOptions& options) {
  IniSection s = ini.section("motion", "Ways in which odometry and motion go together");
  const auto names =
      s.get("modes", std::vector<std::string>{},
            "names, e.g. 'normal slip': every motion followed one of them; empty: all are alike");
  const std::size_t n = names.size();
  if (n == 1) s.fail("modes", "names one mode; give two or more, or none");
  const auto shares = per_mode(
      s, "share", n, {1.0, 0.5},
      "per mode, which part of the measured motion is real; empty: 1, of a second mode 0.5",
      {0, 10});
  const auto sigmas = per_mode(
      s, "share_sigma", n, {0.0, 0.3},
      "per mode, uncertainty of that part, beside the noise of odometry; empty: 0, of a second "
      "mode 0.3",
      {0, 10});
  const auto angles = per_mode(s, "sigma_deg", n, {0.0, 3.0},
                               "per mode, noise added to the rotation [deg]; empty: 0, of a second "
                               "mode 3",
                               {0, 360});
  for (std::size_t i = 0; i < n; ++i) {
    options.modes.push_back({names[i], shares[i], sigmas[i], angles[i] * (M_PI / 180)});
  }
  if (n > 1) options.chain = read_chain(s, n);
  if (n == 0) s.get("transition", std::vector<double>{}, kTransitionMeaning, kProbability);
}

/// The odometry corrected for a mode, with its added noise.
OdometryIncrement in_mode(OdometryIncrement odometry, const MotionMode& mode) {
  const double driven = odometry.mean.norm();
  const double added = std::pow(mode.share_sigma * driven, 2);
  const double turned = mode.sigma_rad * mode.sigma_rad;
  odometry.mean.x(mode.share * odometry.mean.x());
  odometry.mean.y(mode.share * odometry.mean.y());
  odometry.mean.z(mode.share * odometry.mean.z());
  const Eigen::Index axes = odometry.is_planar ? 2 : 3;
  odometry.covariance.topLeftCorner(axes, axes).diagonal().array() += added;
  odometry.covariance(5, 5) += turned;
  if (!odometry.is_planar) odometry.covariance.diagonal().segment<2>(3).array() += turned;
  return odometry;
}

}  // namespace

MotionOptions read_motion_options(IniFile& ini) {
  MotionOptions options;
  IniSection odometry = ini.section("odometry", "Noise of the motion from keyframe to keyframe");
  odometry.read("sigmas", options.odometry_sigmas,
                "standard deviations of x y angle, or in space of x y z and the rotation vector "
                "[m, rad], in the frame of the robot; empty: the covariance in the log",
                {1e-7, 1e3});
  odometry.read(
      "standstill_sigma_m", options.standstill_sigma_m,
      "where odometry says exactly no motion, as wheels at rest do, its noise [m]; 0: as any",
      or_zero(kSigmaMetres));
  options.standstill_sigma_rad =
      odometry.degrees("standstill_sigma_deg", 0.001, "the same for the rotation", kSigmaDegrees);
  odometry.read("steady_sigma_m", options.steady_sigma_m,
                "for a robot at steady speed: by how much its step changes between keyframes [m]; "
                "0: anything",
                or_zero(kSigmaMetres));
  read_modes(ini, options);
  odometry.read("lost_sigma_m", options.lost_sigma_m,
                "where odometry is missing, the robot is taken to stand still with this sigma",
                kSigmaMetres);
  options.lost_sigma_rad =
      odometry.degrees("lost_sigma_deg", 30.0, "the same for the rotation", kSigmaDegrees);
  IniSection prior = ini.section("prior", "The first pose, which is the origin of the map");
  prior.read("sigma_m", options.prior_sigma_m, "of its position [m]", kSigmaMetres);
  prior.read("sigma_rad", options.prior_sigma_rad, "of its rotation [rad]", kSigmaRadians);
  return options;
}

void check(const MotionOptions& options, bool is_3d) {
  const std::size_t wanted = is_3d ? 6 : 3, given = options.odometry_sigmas.size();
  if (given == 0 || given == wanted) return;
  throw Error(fmt::format("[odometry] sigmas has {} numbers, but the map is {}: give {} or none",
                          given, is_3d ? "in space" : "in the plane", wanted));
}

ContinuousFactorPtr origin_factor(Key pose, const MotionOptions& options, bool is_3d) {
  if (options.start) {
    const Noise noise = Noise::covariance(options.start->covariance);
    const Eigen::Isometry3d& T = options.start->T_map_robot;
    if (is_3d) return std::make_shared<Prior<SE3>>(pose, to_se3(T), noise);
    return std::make_shared<Prior<SE2>>(pose, to_se2(T), noise);
  }
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

HybridFactorPtr switching_factor(DiscreteKey mode, Key a, Key b, const OdometryIncrement& odometry,
                                 const MotionOptions& options, bool is_3d,
                                 const std::optional<Key>& calibration) {
  OdometryIncrement noisy = odometry;
  const std::vector<double>& s = options.odometry_sigmas;
  if (!s.empty()) {  // from here on, the covariance of the increment includes all noise
    noisy.covariance.setZero();
    for (std::size_t i = 0; i < s.size(); ++i) {
      const auto at = static_cast<Eigen::Index>(is_3d || i < 2 ? i : 5);
      noisy.covariance(at, at) = s[i] * s[i];
    }
  }
  MotionOptions by_covariance = options;
  by_covariance.odometry_sigmas.clear();
  std::vector<MixtureComponent> components;
  for (const MotionMode& m : options.modes) {
    components.push_back(
        {odometry_factor(a, b, in_mode(noisy, m), by_covariance, is_3d, calibration)});
  }
  return std::make_shared<Mixture>(std::vector<DiscreteKey>{mode}, std::move(components));
}

ContinuousFactorPtr steady_factor(Key a, Key b, Key c, const MotionOptions& options, bool is_3d) {
  const Noise noise = Noise::isotropic(is_3d ? 3 : 2, options.steady_sigma_m);
  if (is_3d) return std::make_shared<SteadyMotion<SE3>>(a, b, c, noise, Loss::cauchy());
  return std::make_shared<SteadyMotion<SE2>>(a, b, c, noise, Loss::cauchy());
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
