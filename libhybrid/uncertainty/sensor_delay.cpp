// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/sensor_delay.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libhybrid/core/quantile.h"
#include "libhybrid/core/spatial_values.h"
#include "libhybrid/geometry/polar.h"

namespace hybrid {
namespace {

constexpr double kLongest = 1.0;  // s, the longest delay, and time between two frames
constexpr double kStep = 0.04;    // s, of the delays tried: shorter than motion changes in
constexpr int kMostSteps = static_cast<int>(kLongest / kStep);
constexpr int kTried = 2 * kMostSteps + 1;
constexpr Eigen::Index kParts = 10;  // of the log, for the jackknife
constexpr double kSigmas = 3;        // of a delay that is none by chance

double delay_of(int tried) {
  return kStep * (tried - kMostSteps);
}

/// Pairs of successive frames that both saw something, by the number of the second.
std::vector<std::size_t> successors(const std::vector<TimedSightings>& frames) {
  std::vector<std::size_t> out;
  for (std::size_t i = 1; i < frames.size(); ++i) {
    const double apart = frames[i].time - frames[i - 1].time;
    const bool both = !frames[i].seen.empty() && !frames[i - 1].seen.empty();
    if (both && apart > 0 && apart <= kLongest) out.push_back(i);
  }
  return out;
}

Eigen::VectorXd polar_of(const Eigen::Vector3d& point, Eigen::Index dim) {
  if (dim == 2) return to_polar(Eigen::Vector2d(point.head<2>()));
  return to_polar(point);
}

Eigen::Vector3d point_of(const MeasuredPoint& measured) {
  if (measured.z.size() == 3) return from_polar(Eigen::Vector3d(measured.z));
  return padded_point(from_polar(Eigen::Vector2d(measured.z)));
}

/// Squared distances [sigmas] of what the first of two frames saw to the nearest that the second
/// saw, once moved by `T_second_first` of the sensor.
void add_distances(const TimedSightings& first, const TimedSightings& second,
                   const SE3& T_second_first, std::vector<double>& out) {
  for (const MeasuredPoint& a : first.seen) {
    const Eigen::VectorXd expected = polar_of(T_second_first * point_of(a), a.z.size());
    double nearest = std::numeric_limits<double>::infinity();
    for (const MeasuredPoint& b : second.seen) {
      if (b.z.size() != a.z.size()) continue;
      Eigen::VectorXd v = b.z - expected;
      v[1] = wrap_angle(v[1]);
      nearest = std::min(nearest, gaussian_score(v, a.covariance + b.covariance).chi_square);
    }
    if (std::isfinite(nearest)) out.push_back(nearest);
  }
}

/// The distances of all pairs of frames, by part of the log, at one delay.
std::vector<std::vector<double>> distances(const std::vector<OdometryPose>& odometry,
                                           const std::vector<TimedSightings>& frames,
                                           const std::vector<std::size_t>& pairs, double delay) {
  std::vector<std::vector<double>> parts(kParts);
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    const TimedSightings &first = frames[pairs[k] - 1], &second = frames[pairs[k]];
    const SE3 T_first = pose_at(odometry, first.time - delay) * first.T_robot_sensor;
    const SE3 T_second = pose_at(odometry, second.time - delay) * second.T_robot_sensor;
    add_distances(first, second, T_second.between(T_first), parts[k * kParts / pairs.size()]);
  }
  return parts;
}

/// The delay of least cost, by the parabola through the costs about the least; among equals the
/// shortest.
double least(const Eigen::VectorXd& cost) {
  int best = kTried / 2;
  for (int away = 1; away <= kTried / 2; ++away) {
    for (const int tried : {kTried / 2 - away, kTried / 2 + away}) {
      if (cost[tried] < cost[best]) best = tried;
    }
  }
  if (best == 0 || best == kTried - 1) return delay_of(best);
  const double before = cost[best - 1] - cost[best], after = cost[best + 1] - cost[best];
  if (!(before + after > 0)) return delay_of(best);
  return delay_of(best) + 0.5 * kStep * (before - after) / (before + after);
}

}  // namespace

SE3 pose_at(const std::vector<OdometryPose>& odometry, double time) {
  const auto after =
      std::upper_bound(odometry.begin(), odometry.end(), time,
                       [](double t, const OdometryPose& pose) { return t < pose.time; });
  if (after == odometry.begin()) return after->pose;
  const OdometryPose& before = *std::prev(after);
  if (after == odometry.end()) return before.pose;
  const double share = (time - before.time) / (after->time - before.time);
  return before.pose * SE3::exp(share * before.pose.between(after->pose).log());
}

bool SensorDelay::is_significant() const {
  return std::abs(seconds) > kSigmas * sigma;
}

SensorDelay estimate_sensor_delay(const std::vector<OdometryPose>& odometry,
                                  const std::vector<TimedSightings>& sightings) {
  SensorDelay none{0, std::numeric_limits<double>::infinity()};
  const std::vector<std::size_t> pairs = successors(sightings);
  if (odometry.empty() || static_cast<Eigen::Index>(pairs.size()) < kParts) return none;
  std::vector<std::vector<std::vector<double>>> all;  // by delay, part
  double scale = std::numeric_limits<double>::infinity();
  for (int tried = 0; tried < kTried; ++tried) {
    all.push_back(distances(odometry, sightings, pairs, delay_of(tried)));
    scale = std::min(scale, median_of_all(all.back()));
  }
  if (!(scale > 0)) return none;
  Eigen::MatrixXd cost = Eigen::MatrixXd::Zero(kTried, kParts);
  for (int tried = 0; tried < kTried; ++tried) {
    for (Eigen::Index part = 0; part < kParts; ++part) {
      for (const double d : all[tried][part]) cost(tried, part) += std::log1p(d / scale);
    }
  }
  const Eigen::VectorXd sum = cost.rowwise().sum();
  if (!(sum.maxCoeff() > sum.minCoeff()) || std::abs(least(sum)) >= kLongest) return none;
  Eigen::Array<double, kParts, 1> without;  // each part in turn
  for (Eigen::Index part = 0; part < kParts; ++part) without[part] = least(sum - cost.col(part));
  const double spread = (without - without.mean()).square().mean();
  return {least(sum), std::sqrt((kParts - 1) * spread)};
}

}  // namespace hybrid
