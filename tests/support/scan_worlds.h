// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <random>
#include <utility>
#include <vector>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/scans/laser_scan.h"

namespace hybrid::testing {

/// A floor plan of walls, and what a laser sees in it.
class FloorPlan {
 public:
  void add_wall(const Eigen::Vector2d& from, const Eigen::Vector2d& to) {
    walls_.push_back({from, to});
  }
  /// The four walls of a rectangle.
  void add_box(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
    const Eigen::Vector2d a(high.x(), low.y());
    const Eigen::Vector2d b(low.x(), high.y());
    add_wall(low, a);
    add_wall(a, high);
    add_wall(high, b);
    add_wall(b, low);
  }

  /// Distance from a place to the nearest wall in a direction; infinite where there is none.
  double distance(const Eigen::Vector2d& from, double angle) const {
    const Eigen::Vector2d d(std::cos(angle), std::sin(angle));
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [a, b] : walls_) {
      const Eigen::Vector2d along = b - a;
      const double cross = d.x() * along.y() - d.y() * along.x();
      if (std::abs(cross) < 1e-12) continue;
      const Eigen::Vector2d to = a - from;
      const double range = (to.x() * along.y() - to.y() * along.x()) / cross;
      const double share = (to.x() * d.y() - to.y() * d.x()) / cross;
      if (range > 0.0 && share >= 0.0 && share <= 1.0) least = std::min(least, range);
    }
    return least;
  }

  /// `rays` over 180 degrees, with noise of `sigma` [m].
  template <class Random>
  LaserScan scan(const SE2& pose, int rays, double sigma, Random& random,
                 double max_range = 30.0) const {
    LaserScan scan;
    scan.first_angle = -0.5 * M_PI;
    scan.angle_step = M_PI / (rays - 1);
    scan.max_range = max_range;
    std::normal_distribution<double> noise(0.0, sigma);
    for (int i = 0; i < rays; ++i) {
      const double angle = pose.angle() + scan.first_angle + i * scan.angle_step;
      const double range = distance(pose.translation(), angle) + noise(random);
      scan.ranges.push_back(range < max_range ? static_cast<float>(range)
                                              : std::numeric_limits<float>::quiet_NaN());
    }
    return scan;
  }

 private:
  std::vector<std::pair<Eigen::Vector2d, Eigen::Vector2d>> walls_;
};

/// A room of 8 m by 6 m around the origin with a niche and a pillar: no two views are alike.
inline FloorPlan furnished_room() {
  FloorPlan plan;
  plan.add_box({-4, -3}, {4, 3});
  plan.add_box({2.5, 1.8}, {4, 3});
  plan.add_box({-1.5, 1.0}, {-1.1, 1.4});
  plan.add_wall({-4, -1}, {-2.8, -1.6});
  return plan;
}

/// Pillars of 0.3 m by 0.4 m at random places within 8 m of the origin: no long walls.
template <class Random>
FloorPlan pillars(int count, Random& random) {
  std::uniform_real_distribution<double> place(-8.0, 8.0);
  FloorPlan plan;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector2d low(place(random), place(random));
    if (low.norm() > 1.5) plan.add_box(low, low + Eigen::Vector2d(0.3, 0.4));
  }
  return plan;
}

/// A ring of corridors 2 m wide around a block of 16 m by 12 m, with niches at uneven places.
inline FloorPlan ring() {
  FloorPlan plan;
  plan.add_box({0, 0}, {16, 12});
  plan.add_box({-2, -2}, {18, 14});
  plan.add_box({3, -2}, {4, -1.6});
  plan.add_box({9.5, -0.4}, {10.1, 0});
  plan.add_box({17.5, 3}, {18, 4.2});
  plan.add_box({16, 8}, {16.3, 8.5});
  plan.add_box({12, 13.5}, {13, 14});
  plan.add_box({5, 12}, {5.7, 12.4});
  plan.add_box({-2, 9}, {-1.7, 10});
  plan.add_box({-0.4, 4}, {0, 4.4});
  return plan;
}

/// Poses every `step` [m] along the ring of corridors, counter-clockwise, turning at its corners.
inline std::vector<SE2> way_around_ring(int rounds, double step) {
  const std::vector<Eigen::Vector2d> corners = {{17, -1}, {17, 13}, {-1, 13}, {-1, -1}};
  std::vector<SE2> way;
  Eigen::Vector2d at(-1, -1);
  double heading = 0.0;
  for (int round = 0; round < rounds; ++round) {
    for (const Eigen::Vector2d& corner : corners) {
      const Eigen::Vector2d leg = corner - at;
      const int steps = static_cast<int>(std::lround(leg.norm() / step));
      for (int i = 0; i < steps; ++i) {
        const Eigen::Vector2d p = at + leg * (double(i) / steps);
        way.emplace_back(p.x(), p.y(), heading);
      }
      for (int i = 0; i < 9; ++i) way.emplace_back(corner.x(), corner.y(), heading + i * M_PI / 18);
      at = corner;
      heading += 0.5 * M_PI;
    }
  }
  return way;
}

}  // namespace hybrid::testing
