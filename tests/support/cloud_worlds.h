// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "libhybrid/geometry/se3.h"

namespace hybrid::testing {

struct Box3 {
  Eigen::Vector3d low, high;
};

/// A hall seen from within, with boxes in it.
struct CloudWorld {
  Box3 hall;
  std::vector<Box3> boxes;
};

/// A hall of 24 x 16 x 4 m with pillars and crates, no two parts of which look alike.
inline CloudWorld cluttered_hall() {
  CloudWorld world{{{-12, -8, -1}, {12, 8, 3}}, {}};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> x(-11, 11), y(-7, 7), size(0.3, 1.5), height(0.5, 4);
  while (world.boxes.size() < 30) {
    const Eigen::Vector3d at{x(random), y(random), -1};
    const Eigen::Vector3d edges{size(random), size(random), height(random)};
    if (std::abs(at.head<2>().norm() - 5) < 1.8) continue;  // the way around
    world.boxes.push_back({at, at + edges});
  }
  return world;
}

/// A hall of 48 x 12 x 4 m with pillars and crates beside the way along it; other seeds are other
/// halls.
inline CloudWorld long_hall(unsigned seed = 3) {
  CloudWorld world{{{-24, -6, -1}, {24, 6, 3}}, {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> x(-23, 23), y(-5, 5), size(0.3, 1.5), height(0.5, 4);
  while (world.boxes.size() < 40) {
    const Eigen::Vector3d at{x(random), y(random), -1};
    const Eigen::Vector3d edges{size(random), size(random), height(random)};
    if (at.y() > -2.5 && at.y() < 1) continue;  // the way
    world.boxes.push_back({at, at + edges});
  }
  return world;
}

/// Distance along a ray to a box seen from outside, or from within; infinity where it is missed.
inline double distance_to(const Box3& box, const Eigen::Vector3d& from, const Eigen::Vector3d& ray,
                          bool within) {
  double enters = -std::numeric_limits<double>::infinity();
  double leaves = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double a = (box.low[i] - from[i]) / ray[i], b = (box.high[i] - from[i]) / ray[i];
    enters = std::max(enters, std::min(a, b));
    leaves = std::min(leaves, std::max(a, b));
  }
  if (within) return leaves;
  return enters > 0 && enters < leaves ? enters : std::numeric_limits<double>::infinity();
}

/// Points in the frames that a lidar had when it saw them, and the times of these [s].
struct Sweep {
  std::vector<Eigen::Vector3f> points;
  std::vector<float> times;
};

/// What a lidar of 32 rings over 60 degrees sees that turns once around from time 0 to `duration`
/// [s], each ray from the place `pose_at(time)`; errors of ranges of 1 cm.
template <class PoseAt>
Sweep sweep_at(const CloudWorld& world, const PoseAt& pose_at, double duration,
               std::mt19937& random, double sigma = 0.01) {
  constexpr int kRings = 32, kColumns = 360;
  std::normal_distribution<double> noise(0, sigma);
  Sweep out;
  for (int ring = 0; ring < kRings; ++ring) {
    const double up = (ring - kRings / 2) * 2 * M_PI / 180 + 1e-4;
    for (int column = 0; column < kColumns; ++column) {
      const double around = column * 2 * M_PI / kColumns + 1e-4;
      const double time = duration * column / kColumns;
      const SE3 pose = pose_at(time);
      const Eigen::Vector3d own(std::cos(up) * std::cos(around), std::cos(up) * std::sin(around),
                                std::sin(up));
      const Eigen::Vector3d ray = pose.rotation() * own;
      double range = distance_to(world.hall, pose.translation(), ray, true);
      for (const Box3& box : world.boxes) {
        range = std::min(range, distance_to(box, pose.translation(), ray, false));
      }
      out.points.push_back(((range + noise(random)) * own).cast<float>());
      out.times.push_back(static_cast<float>(time));
    }
  }
  return out;
}

/// What it sees at once.
inline std::vector<Eigen::Vector3f> cloud_at(const CloudWorld& world, const SE3& pose,
                                             std::mt19937& random, double sigma = 0.01) {
  return sweep_at(
             world, [&](double) { return pose; }, 0, random, sigma)
      .points;
}

/// On a circle of 5 m around the middle of the hall, after this angle [rad], nodding a little.
inline SE3 place_around_hall(double a) {
  constexpr double kRadius = 5;
  const Eigen::Vector3d at(kRadius * std::cos(a), kRadius * std::sin(a), 0.1 * std::sin(3 * a));
  return {at, SO3::exp(Eigen::Vector3d(0, 0, a + M_PI / 2)) *
                  SO3::exp(Eigen::Vector3d(0.03 * std::sin(2 * a), 0, 0))};
}

/// Once around the hall and a quarter more, `step` metres apart.
inline std::vector<SE3> way_around_hall(double step) {
  std::vector<SE3> out;
  for (double a = 0; a < 2.5 * M_PI; a += step / 5) out.push_back(place_around_hall(a));
  return out;
}

/// Along the long hall, `step` metres apart, from one x to another, swaying a little.
inline std::vector<SE3> way_along_hall(double step, double from, double to) {
  const double sign = to > from ? 1 : -1;
  std::vector<SE3> out;
  for (double way = 0; way < std::abs(to - from); way += step) {
    const double x = from + sign * way;
    out.emplace_back(
        Eigen::Vector3d(x, 0.5 * std::sin(0.3 * x), 0.1 * std::sin(x)),
        SO3::exp(Eigen::Vector3d(0, 0, 0.15 * std::cos(0.3 * x) + (to > from ? 0 : M_PI))) *
            SO3::exp(Eigen::Vector3d(0.03 * std::sin(2 * x), 0, 0)));
  }
  return out;
}

}  // namespace hybrid::testing
