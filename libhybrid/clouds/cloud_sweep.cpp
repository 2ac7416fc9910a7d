// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_sweep.h"

#include <cmath>

namespace hybrid {
namespace {

constexpr double kLongestStep = 2;  // s, from cloud to cloud

}  // namespace

std::vector<Eigen::Vector3f> deskewed(std::vector<Eigen::Vector3f> points,
                                      const std::vector<float>& times,
                                      const SE3::Tangent& velocity) {
  if (times.size() != points.size() || velocity.isZero(0)) return points;
  float time = 0;
  Eigen::Isometry3f T = Eigen::Isometry3f::Identity();  // in the frame at the stamp
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(std::abs(times[i]) <= kLongestSweep)) continue;
    if (times[i] != time) {  // several points are often of one time
      time = times[i];
      T.matrix() = SE3::exp(static_cast<double>(time) * velocity).matrix().cast<float>();
    }
    points[i] = T * points[i];
  }
  return points;
}

std::optional<SE3::Tangent> SweepVelocity::mean(double time, const SE3& motion) const {
  const double step = last_ ? time - *last_ : 0;
  if (!(step > 0 && step <= kLongestStep)) return std::nullopt;
  return motion.log() / step;
}

SE3::Tangent SweepVelocity::at(double time, const std::optional<SE3>& odometry) const {
  std::optional<SE3::Tangent> velocity = matched_;
  if (odometry) velocity = mean(time, *odometry);
  if (!last_ || time - *last_ > kLongestStep) velocity.reset();
  return velocity.value_or(SE3::Tangent::Zero());
}

void SweepVelocity::add(double time, const std::optional<SE3>& matched) {
  if (matched) matched_ = mean(time, *matched);
  last_ = time;
}

}  // namespace hybrid
