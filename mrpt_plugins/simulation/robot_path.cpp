// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/simulation/robot_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "libhybrid/core/error.h"
#include "mrpt_plugins/simulation/random.h"

namespace hybrid {
namespace {

struct PlanarPose {
  double x = 0, y = 0, heading = 0;
  double travelled = 0;
};

constexpr double kMostFrames = 1e6;

void check_count(double frames) {
  if (frames <= kMostFrames) return;
  throw Error(fmt::format("[path] step is so short that the path has more than {:.0f} frames",
                          kMostFrames));
}

std::vector<PlanarPose> circle(const DrivenPath& path) {
  const double turn = 2 * M_PI * path.laps;
  check_count(turn * path.radius / path.step);
  const auto steps = std::max(1L, std::lround(turn * path.radius / path.step));
  std::vector<PlanarPose> poses;
  for (long i = 0; i <= steps; ++i) {
    const double angle = turn * static_cast<double>(i) / static_cast<double>(steps);
    poses.push_back({path.radius * std::sin(angle), path.radius * (1 - std::cos(angle)), angle,
                     path.radius * angle});
  }
  return poses;
}

std::vector<double> lawnmower(const DrivenPath& path) {
  std::vector<double> points;
  for (int lane = 0; lane < path.lanes; ++lane) {
    const double y = lane * path.lane_spacing;
    const double from = lane % 2 == 0 ? 0 : path.width;
    points.insert(points.end(), {from, y, path.width - from, y});
  }
  points.insert(points.end(), {0, 0});
  return points;
}

/// Turns on the spot at each waypoint, then drives straight to the next.
std::vector<PlanarPose> through(const std::vector<double>& waypoints, const DrivenPath& path) {
  std::vector<PlanarPose> poses{{}};
  for (int lap = 0; lap < path.laps; ++lap) {
    for (std::size_t i = 0; i + 1 < waypoints.size(); i += 2) {
      PlanarPose now = poses.back();
      const double dx = waypoints[i] - now.x, dy = waypoints[i + 1] - now.y;
      const double distance = std::hypot(dx, dy);
      if (distance < 1e-6) continue;
      const double turn = std::remainder(std::atan2(dy, dx) - now.heading, 2 * M_PI);
      const double turns = std::ceil(std::abs(turn) / path.max_turn - 1e-9);
      for (int k = 0; k < static_cast<int>(turns); ++k) {
        now.heading += turn / turns;
        poses.push_back(now);
      }
      const PlanarPose start = now;
      const double steps = std::max(1.0, std::ceil(distance / path.step - 1e-9));
      check_count(static_cast<double>(poses.size()) + steps);
      for (int k = 1; k <= static_cast<int>(steps); ++k) {
        const double done = k / steps;
        poses.push_back({start.x + done * dx, start.y + done * dy, start.heading,
                         start.travelled + done * distance});
      }
    }
  }
  return poses;
}

}  // namespace

std::vector<mrpt::poses::CPose3D> robot_path(const DrivenPath& path, bool is_3d) {
  const std::vector<PlanarPose> plan =
      path.shape == "circle"
          ? circle(path)
          : through(path.shape == "lawnmower" ? lawnmower(path) : path.waypoints, path);
  const double length = std::max(plan.back().travelled, 1e-9);
  std::vector<mrpt::poses::CPose3D> poses;
  for (const PlanarPose& p : plan) {
    const double frequency = 2 * M_PI * path.waves / length;
    const double phase = frequency * p.travelled;
    const double z = is_3d ? path.height / 2 * (1 - std::cos(phase)) : 0;
    const double slope = is_3d ? path.height / 2 * frequency * std::sin(phase) : 0;
    const double roll = is_3d ? path.roll * std::sin(phase) : 0;
    const mrpt::poses::CPose3D seen_from_start(quantised(p.x), quantised(p.y), quantised(z),
                                               quantised(p.heading), quantised(-std::atan(slope)),
                                               quantised(roll));
    poses.push_back(path.start == mrpt::poses::CPose3D() ? seen_from_start
                                                         : path.start + seen_from_start);
  }
  return poses;
}

}  // namespace hybrid
