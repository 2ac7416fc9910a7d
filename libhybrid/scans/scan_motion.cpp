// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_motion.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "libhybrid/core/quantile.h"

namespace hybrid {
namespace {

/// Errors of odometry at scale 1: of wheels on a floor. Shares of the distance and of the turn,
/// angle per distance [rad/m], distance per angle [m/rad], and what even no motion has [m], [rad].
constexpr double kOfDistance = 0.05;
constexpr double kOfTurn = 0.05;
constexpr double kAnglePerDistance = 0.02;
constexpr double kDistancePerAngle = 0.02;
constexpr double kLeastTranslation = 0.005;
constexpr double kLeastRotation = 0.003;
/// Only a motion of so many of these errors tells the scale of odometry. What is smaller is mostly
/// error itself: a fit to it would take the odometry of a robot that goes straight for turns that
/// are far too large.
constexpr double kClear = 5.0;
/// Only turns of at most this [rad] along the path tell the scale of turns: of one that comes near
/// half a turn, odometry and match may be on two sides of the jump of angles.
constexpr double kMostComparedTurn = 2.5;
/// Number of keyframes that tell the scale, and of errors of scale 1 that are assumed before.
constexpr std::size_t kMemory = 60;
constexpr std::size_t kPrior = 10;
/// Standard deviations of scale and drift [rad/m] before anything was compared: of wheels that are
/// worn or measured badly.
constexpr double kScaleSigma = 0.1;
constexpr double kDriftSigma = 0.02;
/// A comparison that is off by more standard deviations tells nothing of scale and drift.
constexpr double kSurprise = 4.0;
/// Scales are within these.
constexpr double kLeastScale = 0.2;
constexpr double kMostScale = 50.0;
/// Medians of the norm of a standard normal vector of one and two dimensions.
constexpr double kMedian1 = 0.6745;
constexpr double kMedian2 = 1.1774;

double translation_sigma(double distance, double turn) {
  return std::sqrt(std::pow(kOfDistance * distance, 2) + std::pow(kDistancePerAngle * turn, 2) +
                   std::pow(kLeastTranslation, 2));
}

double rotation_sigma(double distance, double turn) {
  return std::sqrt(std::pow(kOfTurn * turn, 2) + std::pow(kAnglePerDistance * distance, 2) +
                   std::pow(kLeastRotation, 2));
}

}  // namespace

void OdometryNoise::Scale::add(double error, double degrees_of_freedom) {
  errors.push_back(error / (degrees_of_freedom > 1.0 ? kMedian2 : kMedian1));
  if (errors.size() > kMemory) errors.pop_front();
  std::vector<double> known(errors.begin(), errors.end());
  if (known.size() < kPrior) known.resize(kPrior, 1.0);
  scale = std::clamp(median(std::move(known)), kLeastScale, kMostScale);
}

Eigen::Matrix3d OdometryNoise::covariance(double distance, double turn) const {
  const double t = translation_.scale * translation_sigma(distance, turn);
  const double r = rotation_.scale * rotation_sigma(distance, turn);
  return Eigen::Vector3d(t * t, t * t, r * r).asDiagonal();
}

OdometryCalibration2 OdometryNoise::calibration() const {
  const double known = 1.0 / (kScaleSigma * kScaleSigma);
  const double length = (length_.g[0] + known) / (length_.H(0, 0) + known);
  const Eigen::Vector2d prior(known, 1.0 / (kDriftSigma * kDriftSigma));
  const Eigen::Matrix2d H = angle_.H + Eigen::Matrix2d(prior.asDiagonal());
  const Eigen::Vector2d g = angle_.g + Eigen::Vector2d(known, 0.0);
  Eigen::Vector2d angle = H.inverse() * g;
  if (!(angle[0] > 0.0)) angle = {1.0, (g[1] - H(1, 0)) / H(1, 1)};
  return {length > 0.0 ? length : 1.0, angle[0], angle[1]};
}

void OdometryNoise::compare(const SE2& stated, const SE2& corrected, double distance, double turn,
                            const UncertainMotion& match) {
  const Eigen::Vector3d error = corrected.between(match.motion).log();
  const double t = translation_sigma(distance, turn);
  const double r = rotation_sigma(distance, turn);
  const Eigen::Matrix2d C = match.covariance.topLeftCorner<2, 2>();
  const double match_t = std::sqrt(C.trace());
  const double match_r = std::sqrt(match.covariance(2, 2));
  if (match_t < t * translation_.scale + kLeastTranslation) {
    const double sigma = std::hypot(match_t, t * translation_.scale);
    translation_.add(error.head<2>().norm() / t, 2.0);
    const Eigen::Vector2d& d = stated.translation();
    if (d.norm() > kClear * t && error.head<2>().norm() < kSurprise * sigma) {
      length_.H(0, 0) += d.squaredNorm() / (sigma * sigma);
      length_.g[0] += d.dot(match.motion.translation()) / (sigma * sigma);
    }
  }
  if (match_r < r * rotation_.scale + kLeastRotation) {
    const double sigma = std::hypot(match_r, r * rotation_.scale);
    rotation_.add(std::abs(error.z()) / r, 1.0);
    if (turn <= kMostComparedTurn && std::abs(error.z()) < kSurprise * sigma) {
      const bool is_turn = std::abs(stated.angle()) > kClear * r;
      const Eigen::Vector2d of(is_turn ? stated.angle() : 0.0, distance);
      angle_.H += of * of.transpose() / (sigma * sigma);
      const double told = match.motion.angle() - (is_turn ? 0.0 : stated.angle());
      angle_.g += of * (told / (sigma * sigma));
    }
  }
}

}  // namespace hybrid
