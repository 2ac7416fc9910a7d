// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "libhybrid/geometry/isometry.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/uncertainty/agreement.h"

namespace hybrid::testing {

inline constexpr double kLap = 80;  // [s]
inline constexpr double kSigmaRange = 0.1, kSigmaAngle = 0.01;

/// Where a robot is at a time that drives around in circles of 10 m.
inline SE2 true_pose(double time) {
  const double angle = 2 * M_PI * time / kLap;
  return SE2(10 * std::cos(angle), 10 * std::sin(angle), angle + M_PI / 2);
}

/// The error of a path in the plane, by time.
using PathError = std::function<Eigen::Vector2d(double)>;
inline Eigen::Vector2d none(double) {
  return Eigen::Vector2d::Zero();
}
/// A path that is `metres` off in the second lap, and back again.
inline PathError in_second_lap(double metres) {
  return [metres](double time) {
    return Eigen::Vector2d(metres * std::sin(M_PI * std::clamp(time / kLap - 0.5, 0.0, 1.0)), 0);
  };
}

inline SE2 moved(const SE2& pose, const Eigen::Vector2d& by) {
  return SE2(pose.x() + by.x(), pose.y() + by.y(), pose.angle());
}

inline std::vector<Eigen::Vector3d> things_by(std::mt19937& random, bool is_3d) {
  std::uniform_real_distribution<double> place(-16, 16);
  std::vector<Eigen::Vector3d> things;
  for (int i = 0; i < 60; ++i) things.emplace_back(place(random), place(random), is_3d ? 1 : 0);
  return things;
}

/// Detections of things around the circle, once a period, laid out by a path that has errors.
inline std::vector<PlacedDetections> detections(double seconds, const PathError& error,
                                                unsigned seed = 1, bool is_3d = false,
                                                double period = 1) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> share(0, 1);
  const std::vector<Eigen::Vector3d> things = things_by(random, is_3d);
  std::vector<PlacedDetections> out;
  for (double time = 0; time < seconds; time += period) {
    PlacedDetections frame;
    frame.time = 1.7e9 + time;
    frame.is_3d = is_3d;
    frame.T_map_sensor = to_isometry(moved(true_pose(time), error(time)));
    for (const Eigen::Vector3d& thing : things) {
      Eigen::VectorXd z =
          to_polar(Eigen::Vector3d(to_isometry(true_pose(time)).inverse() * thing)).eval();
      if (z[0] > 9 || std::abs(z[1]) > 1.5 || share(random) < 0.2) continue;
      if (!is_3d) z.conservativeResize(2);
      Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(z.size(), kSigmaAngle);
      sigmas[0] = kSigmaRange;
      for (Eigen::Index i = 0; i < z.size(); ++i) z[i] += sigmas[i] * normal(random);
      frame.seen.push_back({z, sigmas.cwiseAbs2().asDiagonal()});
    }
    out.push_back(std::move(frame));
  }
  return out;
}

}  // namespace hybrid::testing
