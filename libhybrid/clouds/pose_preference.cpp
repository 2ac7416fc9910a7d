// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/pose_preference.h"

#include <cmath>
#include <set>
#include <unordered_map>
#include <utility>

#include "libhybrid/clouds/cloud_alignment.h"

namespace hybrid {
namespace {

constexpr double kDirection = 0.05;  // edge of a bin of directions [rad]
/// Where a pose is wrong, this share of a block lies on surfaces all the same.
constexpr double kChance = 0.1;

/// Points near each other, and the support that they lend to two poses.
struct Block {
  double points = 0, on_a = 0, on_b = 0;
};

using Direction = std::pair<int, int>;  // azimuth, elevation

Direction direction_of(const Eigen::Vector3f& p) {
  const auto bin = [](float angle) { return static_cast<int>(std::floor(angle / kDirection)); };
  return {bin(std::atan2(p.y(), p.x())), bin(std::atan2(p.z(), std::hypot(p.x(), p.y())))};
}

/// Where a robot at that pose would look to see a map.
std::set<Direction> directions_from(const SE3& pose, const CloudSurfaces& map) {
  std::set<Direction> out;
  for (const CloudPoint& point : transformed(pose.inverse(), map.points())) {
    out.insert(direction_of(point.position));
  }
  return out;
}

}  // namespace

double preference(const std::vector<CloudPoint>& points, const CloudSurfaces& map,
                  const CloudSurfaces& known, const SE3& a, const SE3& b, double block) {
  const std::set<Direction> from_a = directions_from(a, known), from_b = directions_from(b, known);
  const std::vector<CloudPoint> at_a = transformed(a, points), at_b = transformed(b, points);
  std::unordered_map<GridCell, Block, GridCellHash> blocks;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Direction direction = direction_of(points[i].position);
    if (from_a.count(direction) == 0 || from_b.count(direction) == 0) continue;
    Block& at = blocks[grid_cell(points[i].position.cast<double>(), block)];
    ++at.points;
    at.on_a += support_of(at_a[i], map);
    at.on_b += support_of(at_b[i], map);
  }
  double sum = 0;
  for (const auto& [cell, at] : blocks) {
    sum += std::log((kChance + at.on_b / at.points) / (kChance + at.on_a / at.points));
  }
  return sum;
}

}  // namespace hybrid
