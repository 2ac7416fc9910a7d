// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_surfaces.h"

#include <algorithm>
#include <cmath>

namespace hybrid {
namespace {

/// Cosine between the normals of points of one surface, and of a point and of a surface that it may
/// lie on.
constexpr float kSameSurface = 0.8F;
constexpr float kMaySame = 0.6F;
/// After so many points a mean no longer moves.
constexpr float kMostCount = 20;

}  // namespace

void CloudSurfaces::add(const std::vector<CloudPoint>& points,
                        const std::vector<SurfaceShifts>& shifts) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].has_normal()) continue;
    add(points[i], shifts.empty() ? SurfaceShifts(SurfaceShifts::Zero()) : shifts[i]);
  }
}

void CloudSurfaces::add(const CloudPoint& point, const SurfaceShifts& shifts) {
  const GridCell cell = grid_cell(point.position.cast<double>(), edge());
  std::vector<std::uint32_t>& here = cells_[cell];
  const auto join = static_cast<float>(spacing_ * spacing_);
  std::uint32_t same = 0;
  float least = join;
  bool is_known = false;
  for (const std::uint32_t i : here) {
    const float distance = (points_[i].position - point.position).squaredNorm();
    if (distance >= least || points_[i].normal.dot(point.normal) < kSameSurface) continue;
    least = distance;
    same = i;
    is_known = true;
  }
  if (!is_known) {
    here.push_back(static_cast<std::uint32_t>(points_.size()));
    points_.push_back(point);
    shifts_.push_back(shifts);
    counts_.push_back(1);
    return;
  }
  if (counts_[same] >= kMostCount) return;
  CloudPoint& mean = points_[same];
  const float share = 1 / ++counts_[same];
  shifts_[same] += share * (shifts - shifts_[same]);
  mean.position += share * (point.position - mean.position);
  mean.normal = (mean.normal + share * (point.normal - mean.normal)).normalized();
}

const CloudPoint* CloudSurfaces::nearest(const Eigen::Vector3f& position,
                                         const Eigen::Vector3f& normal, double radius) const {
  const CloudPoint* best = nullptr;
  const double r = std::min(radius, most_radius());
  auto least = static_cast<float>(r * r);
  // The eight cells that meet nearest to the point reach half an edge at least.
  const Eigen::Vector3d corner = position.cast<double>().array() - edge() / 2;
  const GridCell first = grid_cell(corner, edge());
  for (int i = 0; i < 8; ++i) {
    const auto found = cells_.find(first + GridCell{i & 1, i >> 1 & 1, i >> 2});
    if (found == cells_.end()) continue;
    for (const std::uint32_t k : found->second) {
      const CloudPoint& point = points_[k];
      const float distance = (point.position - position).squaredNorm();
      if (distance >= least || point.normal.dot(normal) < kMaySame) continue;
      best = &point;
      least = distance;
    }
  }
  return best;
}

}  // namespace hybrid
