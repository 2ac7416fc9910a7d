// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/scans/scan_points.h"

namespace HYBRID_API hybrid {

/// Points of surfaces in one frame, those close to each other joined, in a grid for the search of
/// neighbours.
class SurfaceMap {
 public:
  /// A mean of points of one surface.
  struct Surfel {
    Eigen::Vector2d position = Eigen::Vector2d::Zero();
    Eigen::Vector2d normal = Eigen::Vector2d::Zero();  ///< unit, or zero where it is not known
    double count = 0.0;                                ///< of points
    double length = 0.0;                               ///< sum of lengths of the points [m]
  };

  SurfaceMap() = default;
  /// Joins points that are closer than `join` [m] and have similar normals. Points farther than 100
  /// m from the origin of the frame are left out.
  explicit SurfaceMap(const std::vector<SurfacePoint>& points, double join = 0.07);

  /// The surfel nearest to a point of a surface with that normal, at most `radius` away, which is
  /// at most cell_size(); null if there is none.
  const Surfel* nearest(const Eigen::Vector2d& position, const Eigen::Vector2d& normal,
                        double radius) const;

  const std::vector<Surfel>& surfels() const { return surfels_; }
  bool empty() const { return surfels_.empty(); }
  static constexpr double cell_size() { return 0.4; }

 private:
  void make_grid(const std::vector<SurfacePoint>& points);
  void join_cell(const std::vector<SurfacePoint>& points, const std::vector<int>& sorted, int begin,
                 int end, double join);
  int column(double x) const;
  int row(double y) const;

  Eigen::Vector2d corner_ = Eigen::Vector2d::Zero();
  int columns_ = 0, rows_ = 0;
  std::vector<int> starts_;  // of cells, in surfels_
  std::vector<Surfel> surfels_;
};

}  // namespace hybrid
