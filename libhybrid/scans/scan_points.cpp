// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_points.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace hybrid {
namespace {

/// A return closer than this is the robot itself, or a fault of the sensor [m].
constexpr double kMinRange = 0.05;
/// Neighbours on each side that tell a normal: at least, where rays are far apart, and at most.
constexpr int kFewNeighbours = 2;
constexpr int kMostNeighbours = 10;
/// A gap of more than this between neighbouring rays ends a surface: in metres, and as a multiple
/// of the spacing of rays across their direction (which allows for an incidence of 84 degrees).
constexpr double kGap = 0.25;
constexpr double kGapOfSpacing = 10.0;
/// A surface is known where points scatter around a line by less than this, absolutely [m] and
/// relative to their scatter along the line.
constexpr double kMaxRoughness = 0.04;
constexpr double kMaxAspect = 0.2;
/// Cosine of the incidence beyond which a line of points is a row of mixed pixels.
constexpr double kMinCosine = 0.05;
/// A point stands for at most this length, however far the next one is [m].
constexpr double kMaxLength = 0.5;

struct Return {
  Eigen::Vector2d position;
  double range = 0.0;
};

/// Single precision may make a rotation or a whole turn inexact by this.
constexpr double kInexact = 1e-3;

bool is_pose(const Eigen::Isometry3d& T) {
  const Eigen::Matrix3d R = T.linear();
  return T.matrix().allFinite() && R.determinant() > 0.0 &&
         (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < kInexact;
}

/// Whether its numbers can be those of a sweep of a sensor that a robot carries.
bool is_usable(const LaserScan& scan, double max_range) {
  const double turn = 2.0 * M_PI + kInexact;
  return std::abs(scan.first_angle) <= turn &&
         std::abs(scan.angle_step) * (double(scan.ranges.size()) - 1.0) <= turn &&
         is_pose(scan.T_robot_sensor) && scan.T_robot_sensor.translation().norm() <= max_range;
}

Eigen::Vector2d planar(const Eigen::Vector3d& p) {
  return {p.x(), p.y()};
}

std::vector<Return> returns_of(const LaserScan& scan, double max_range) {
  std::vector<Return> returns;
  if (!is_usable(scan, max_range)) return returns;
  returns.reserve(scan.ranges.size());
  const double limit = std::min(max_range, scan.max_range * 0.999);
  for (std::size_t i = 0; i < scan.ranges.size(); ++i) {
    const double range = scan.ranges[i];
    if (!(range >= kMinRange && range <= limit)) continue;
    const double angle = scan.first_angle + double(i) * scan.angle_step;
    const Eigen::Vector3d point(range * std::cos(angle), range * std::sin(angle), 0.0);
    returns.push_back({planar(scan.T_robot_sensor * point), range});
  }
  return returns;
}

/// The normal of the surface at return `i` of rays `step` apart, zero where it is not known.
Eigen::Vector2d normal_at(const std::vector<Return>& returns, int i, double step, double radius,
                          const Eigen::Vector2d& sensor) {
  const Return& centre = returns[i];
  Eigen::Vector2d sum = centre.position;
  Eigen::Matrix2d squares = Eigen::Matrix2d::Zero();
  int count = 1;
  for (const int side : {-1, 1}) {
    for (int n = 1; n <= kMostNeighbours; ++n) {
      const int j = i + side * n;
      if (j < 0 || j >= static_cast<int>(returns.size())) break;
      const Eigen::Vector2d d = returns[j].position - centre.position;
      if (n > kFewNeighbours && d.norm() > radius) break;
      const double reach = std::min(returns[j].range, returns[j - side].range);
      const double gap = (returns[j].position - returns[j - side].position).norm();
      if (gap > std::max(kGap, kGapOfSpacing * step * reach)) break;
      sum += returns[j].position;
      squares += d * d.transpose();
      ++count;
    }
  }
  if (count < 3) return Eigen::Vector2d::Zero();
  const Eigen::Vector2d mean = sum / count - centre.position;
  const Eigen::Matrix2d C = squares / count - mean * mean.transpose();
  // Eigenvalues of a symmetric 2 x 2 matrix.
  const double half = 0.5 * (C(0, 0) + C(1, 1));
  const double root = std::hypot(0.5 * (C(0, 0) - C(1, 1)), C(0, 1));
  const double across = std::sqrt(std::max(half - root, 0.0));
  const double along = std::sqrt(half + root);
  if (across > kMaxRoughness || across > kMaxAspect * along) return Eigen::Vector2d::Zero();
  const double angle = 0.5 * std::atan2(2.0 * C(0, 1), C(0, 0) - C(1, 1));
  Eigen::Vector2d normal(-std::sin(angle), std::cos(angle));
  const Eigen::Vector2d to_sensor = (sensor - centre.position).normalized();
  double cosine = normal.dot(to_sensor);
  if (cosine < 0.0) normal = -normal, cosine = -cosine;
  return cosine < kMinCosine ? Eigen::Vector2d::Zero() : normal;
}

}  // namespace

std::vector<SurfacePoint> scan_points(const LaserScan& scan, const ScanPointOptions& options) {
  const std::vector<Return> returns = returns_of(scan, options.max_range);
  const Eigen::Vector2d sensor = planar(scan.T_robot_sensor.translation());
  const double step = std::abs(scan.angle_step);
  std::vector<SurfacePoint> points;
  int last = -1;
  for (int i = 0; i < static_cast<int>(returns.size()); ++i) {
    const double gap =
        last < 0 ? options.spacing : (returns[i].position - returns[last].position).norm();
    if (gap < options.spacing) continue;
    last = i;
    const Eigen::Vector2d normal = normal_at(returns, i, step, options.radius, sensor);
    points.push_back({returns[i].position, normal, std::min(gap, kMaxLength)});
  }
  return points;
}

std::vector<SurfacePoint> transformed(const SE2& T, const std::vector<SurfacePoint>& points) {
  std::vector<SurfacePoint> result = points;
  for (SurfacePoint& point : result) {
    point.position = T * point.position;
    point.normal = T.rotation() * point.normal;
  }
  return result;
}

}  // namespace hybrid
