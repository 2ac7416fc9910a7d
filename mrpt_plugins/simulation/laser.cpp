// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/simulation/laser.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libhybrid/geometry/eigen.h"

namespace hybrid {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// How far a ray goes until it meets the wall; infinity if it does not.
double distance_to(const Scenario::Wall& wall, const Eigen::Vector2d& from,
                   const Eigen::Vector2d& direction) {
  const Eigen::Vector2d a(wall[0], wall[1]), along = Eigen::Vector2d(wall[2], wall[3]) - a;
  const double side = cross(direction, along);
  if (side == 0) return kNever;
  const double range = cross(a - from, along) / side;
  const double share = cross(a - from, direction) / side;
  return range > 0 && share >= 0 && share <= 1 ? range : kNever;
}

/// The same for a disc.
double distance_to_disc(const Eigen::Vector2d& center, double radius, const Eigen::Vector2d& from,
                        const Eigen::Vector2d& direction) {
  const Eigen::Vector2d to = center - from;
  const double along = to.dot(direction);
  const double aside = cross(to, direction);
  if (along <= 0 || std::abs(aside) >= radius) return kNever;
  return std::max(0.0, along - std::sqrt(radius * radius - aside * aside));
}

}  // namespace

std::vector<float> simulated_scan(const Scenario::Laser& laser,
                                  const mrpt::poses::CPose3D& T_map_sensor,
                                  const std::vector<SimulatedMover>& movers, std::size_t frame,
                                  Random& random) {
  const Eigen::Vector2d from(T_map_sensor.x(), T_map_sensor.y());
  const double step = laser.rays > 1 ? laser.fov / (laser.rays - 1) : 0;
  const double first = laser.rays > 1 ? -laser.fov / 2 : 0;
  std::vector<float> ranges;
  for (int i = 0; i < laser.rays; ++i) {
    const double angle = T_map_sensor.yaw() + first + i * step;
    const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
    double range = kNever;
    for (const Scenario::Wall& wall : laser.walls) {
      range = std::min(range, distance_to(wall, from, direction));
    }
    for (const Scenario::Wall& pane : laser.glass) {
      const double distance = distance_to(pane, from, direction);
      if (distance < range && random.uniform() < laser.glass_seen) range = distance;
    }
    for (const SimulatedMover& mover : movers) {
      const auto& p = mover.path[frame];
      range = std::min(range, distance_to_disc({p[0], p[1]}, laser.person_radius, from, direction));
    }
    const double measured =
        quantised(std::min(range, laser.max_range) + random.normal(laser.sigma_range));
    const bool is_seen = range < laser.max_range && measured > 0 && measured < laser.max_range;
    ranges.push_back(is_seen ? static_cast<float>(measured) : 0.0F);
  }
  return ranges;
}

}  // namespace hybrid
