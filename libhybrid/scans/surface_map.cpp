// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/surface_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>

namespace hybrid {
namespace {

/// Cosine between the normals of points of one surface.
constexpr double kSameSurface = 0.8;
/// Cosine between the normals of a point and of a surface that it may lie on.
constexpr double kMaySame = 0.5;
constexpr double kMaxExtent = 100.0;

bool is_inside(const SurfacePoint& point) {
  return point.position.cwiseAbs().maxCoeff() < kMaxExtent;
}

/// The cell of a coordinate, far outside where that is far.
int cell_of(double coordinate, double corner) {
  constexpr double kFar = 1e6;
  return static_cast<int>(
      std::floor(std::clamp((coordinate - corner) / SurfaceMap::cell_size(), -kFar, kFar)));
}

}  // namespace

int SurfaceMap::column(double x) const {
  return cell_of(x, corner_.x());
}

int SurfaceMap::row(double y) const {
  return cell_of(y, corner_.y());
}

/// Corner and size of the grid, with an empty cell on every side.
void SurfaceMap::make_grid(const std::vector<SurfacePoint>& points) {
  Eigen::AlignedBox2d box;
  for (const SurfacePoint& point : points) {
    if (is_inside(point)) box.extend(point.position);
  }
  if (box.isEmpty()) return;
  corner_ = box.min() - Eigen::Vector2d::Constant(cell_size());
  columns_ = column(box.max().x()) + 2;
  rows_ = row(box.max().y()) + 2;
}

SurfaceMap::SurfaceMap(const std::vector<SurfacePoint>& points, double join) {
  make_grid(points);
  const int cells = columns_ * rows_;
  if (cells == 0) return;
  std::vector<int> ends(cells + 1, 0);
  std::vector<int> cells_of(points.size(), -1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_inside(points[i])) continue;
    cells_of[i] = row(points[i].position.y()) * columns_ + column(points[i].position.x());
    ++ends[cells_of[i] + 1];
  }
  for (int c = 0; c < cells; ++c) ends[c + 1] += ends[c];
  std::vector<int> next(ends.begin(), ends.end() - 1);
  std::vector<int> sorted(ends.back());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (cells_of[i] >= 0) sorted[next[cells_of[i]]++] = static_cast<int>(i);
  }
  starts_.resize(cells + 1);
  for (int c = 0; c < cells; ++c) {
    starts_[c] = static_cast<int>(surfels_.size());
    join_cell(points, sorted, ends[c], ends[c + 1], join);
  }
  starts_[cells] = static_cast<int>(surfels_.size());
}

/// Appends the surfels of one cell.
void SurfaceMap::join_cell(const std::vector<SurfacePoint>& points, const std::vector<int>& sorted,
                           int begin, int end, double join) {
  const std::size_t first = surfels_.size();
  for (int k = begin; k < end; ++k) {
    const SurfacePoint& point = points[sorted[k]];
    Surfel* same = nullptr;
    double nearest = join * join;
    for (std::size_t s = first; s < surfels_.size(); ++s) {
      Surfel& surfel = surfels_[s];
      const double distance = (surfel.position - point.position).squaredNorm();
      if (distance >= nearest) continue;
      if (surfel.normal.isZero() != point.normal.isZero()) continue;
      if (point.has_normal() && surfel.normal.dot(point.normal) < kSameSurface) continue;
      same = &surfel;
      nearest = distance;
    }
    if (same == nullptr) {
      surfels_.push_back({point.position, point.normal, 1.0, point.length});
      continue;
    }
    same->count += 1.0;
    same->length += point.length;
    same->position += (point.position - same->position) / same->count;
    if (point.has_normal()) {
      same->normal += (point.normal - same->normal) / same->count;
      same->normal.normalize();
    }
  }
}

const SurfaceMap::Surfel* SurfaceMap::nearest(const Eigen::Vector2d& position,
                                              const Eigen::Vector2d& normal, double radius) const {
  const Surfel* best = nullptr;
  double least = radius * radius;
  const bool directed = !normal.isZero();
  const int first_row = std::max(row(position.y() - radius), 0);
  const int last_row = std::min(row(position.y() + radius), rows_ - 1);
  const int first_column = std::max(column(position.x() - radius), 0);
  const int last_column = std::min(column(position.x() + radius), columns_ - 1);
  if (first_column > last_column) return nullptr;
  for (int r = first_row; r <= last_row; ++r) {
    const int end = starts_[r * columns_ + last_column + 1];
    for (int s = starts_[r * columns_ + first_column]; s < end; ++s) {
      const Surfel& surfel = surfels_[s];
      const double distance = (surfel.position - position).squaredNorm();
      if (distance >= least || surfel.normal.isZero()) continue;
      if (directed && surfel.normal.dot(normal) < kMaySame) continue;
      best = &surfel;
      least = distance;
    }
  }
  return best;
}

}  // namespace hybrid
