// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "libhybrid/clouds/cloud_points.h"
#include "libhybrid/clouds/grid_cell.h"

namespace HYBRID_API hybrid {

/// By how much a point moves along its normal, see SweepCalibration.
using SurfaceShifts = Eigen::Vector2f;

/// Surfaces in space by means of points near each other, to which further points are matched.
/// Points without a normal are left out.
class CloudSurfaces {
 public:
  /// `spacing`: points of similar normals that are closer are one [m].
  explicit CloudSurfaces(double spacing) : spacing_(spacing) {}

  void add(const std::vector<CloudPoint>& points, const std::vector<SurfaceShifts>& shifts = {});

  /// The means so far.
  const std::vector<CloudPoint>& points() const { return points_; }
  /// Of one of points().
  SurfaceShifts shifts_of(const CloudPoint& point) const {
    return shifts_[static_cast<std::size_t>(&point - points_.data())];
  }
  double spacing() const { return spacing_; }
  /// The largest radius of a search [m].
  double most_radius() const { return kCellSpacings * spacing_ / 2; }
  /// The mean nearest to a point of a surface with that normal, at most `radius` away; null if
  /// there is none.
  const CloudPoint* nearest(const Eigen::Vector3f& position, const Eigen::Vector3f& normal,
                            double radius) const;

 private:
  static constexpr double kCellSpacings = 4;  // edge of a cell
  double edge() const { return kCellSpacings * spacing_; }
  void add(const CloudPoint& point, const SurfaceShifts& shifts);

  double spacing_;
  std::unordered_map<GridCell, std::vector<std::uint32_t>, GridCellHash> cells_;
  std::vector<CloudPoint> points_;
  std::vector<SurfaceShifts> shifts_;
  std::vector<float> counts_;  // of points by mean
};

}  // namespace hybrid
