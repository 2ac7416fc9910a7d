// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "libhybrid/core/evenly_chosen.h"

namespace hybrid {
namespace {

constexpr std::size_t kViewPoints = 2500;
/// A surface is at a place within this share of the spacing, and within [m].
constexpr double kAtPlace = 0.5;
constexpr double kLeastAtPlace = 0.03, kMostAtPlace = 0.2;

double at_place(double spacing) {
  return std::clamp(kAtPlace * spacing, kLeastAtPlace, kMostAtPlace);
}

}  // namespace

CloudView::CloudView(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& sensor,
                     double spacing)
    : surfaces_(spacing),
      sensor_(sensor),
      shortest_(kColumns * kRows, std::numeric_limits<float>::infinity()) {
  surfaces_.add(evenly_chosen(cloud_points(points, sensor, spacing), kViewPoints));
  for (const Eigen::Vector3f& p : points) {
    const Eigen::Vector3f ray = p - sensor;
    const float range = ray.norm();
    if (!(range > 0) || !std::isfinite(range)) continue;
    float& shortest = shortest_[static_cast<std::size_t>(cell_of(ray))];
    shortest = std::min(shortest, range);
  }
}

int CloudView::cell_of(const Eigen::Vector3f& ray) {
  const double around = std::atan2(ray.y(), ray.x()) / (2 * M_PI) + 0.5;
  const double up = std::atan2(ray.z(), ray.head<2>().norm()) / M_PI + 0.5;
  const int column = std::min(kColumns - 1, static_cast<int>(around * kColumns));
  const int row = std::clamp(static_cast<int>(up * kRows), 0, kRows - 1);
  return row * kColumns + column;
}

std::optional<bool> CloudView::finds(const Eigen::Vector3f& position,
                                     const Eigen::Vector3f& normal) const {
  const double same = at_place(surfaces_.spacing());
  const CloudPoint* near = surfaces_.nearest(position, normal, surfaces_.most_radius());
  if (near != nullptr) {
    return std::abs(near->normal.dot(position - near->position)) < same;
  }
  const Eigen::Vector3f ray = position - sensor_;
  const double range = ray.norm();
  const int cell = cell_of(ray), row = cell / kColumns, column = cell % kColumns;
  float shortest = std::numeric_limits<float>::infinity();
  for (int i = std::max(0, row - 1); i <= std::min(kRows - 1, row + 1); ++i) {
    for (const int j : {column + kColumns - 1, column, column + 1}) {
      const int at = i * kColumns + j % kColumns;
      shortest = std::min(shortest, shortest_[static_cast<std::size_t>(at)]);
    }
  }
  // Rays of a cell spread: a surface that is seen at a grazing angle is nearer on one side.
  const double spread = range * M_PI / kRows;
  if (!std::isfinite(shortest) || shortest < range + same + spread) return std::nullopt;
  return false;
}

}  // namespace hybrid
