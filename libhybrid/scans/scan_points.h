// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <bitset>
#include <cstddef>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/scans/laser_scan.h"

namespace HYBRID_API hybrid {

/// A point of a surface in the plane, with the direction of the surface where neighbours tell it.
struct SurfacePoint {
  Eigen::Vector2d position = Eigen::Vector2d::Zero();  ///< [m]
  /// Unit normal, towards the sensor; zero where it is not known.
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();
  /// Length of the surface that it stands for [m].
  double length = 0.0;

  bool has_normal() const { return !normal.isZero(); }
};

struct ScanPointOptions {
  double spacing = 0.05;    ///< between neighbours after thinning [m]
  double radius = 0.15;     ///< of the neighbourhood that tells a normal, if dense enough [m]
  double max_range = 40.0;  ///< longer rays are not used [m]
};

/// The returns of a scan in the frame of the robot at the time of the scan, projected onto its
/// plane, in the order of the rays and thinned. Rays that are not finite, zero, or at the maximum
/// range are left out.
std::vector<SurfacePoint> scan_points(const LaserScan& scan, const ScanPointOptions& options = {});

/// The directions from the robot in which a scan has returns, however far.
class ScanView {
 public:
  ScanView() = default;
  explicit ScanView(const std::vector<SurfacePoint>& points);
  /// Whether a place in the frame of the robot is in such a direction.
  bool contains(const Eigen::Vector2d& position) const;

 private:
  static constexpr std::size_t kSectors = 24;
  static std::size_t sector(const Eigen::Vector2d& position);
  std::bitset<kSectors> seen_;
};

/// The positions of points or surfels.
template <class Point>
std::vector<Eigen::Vector2d> positions_of(const std::vector<Point>& points) {
  std::vector<Eigen::Vector2d> out;
  out.reserve(points.size());
  for (const Point& point : points) out.push_back(point.position);
  return out;
}

/// The points seen from another frame.
std::vector<SurfacePoint> transformed(const SE2& T, const std::vector<SurfacePoint>& points);

}  // namespace hybrid
