// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/scan_points.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

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
/// Ranges with larger errors than this are smoothed to errors of that size [m], by so many
/// neighbours on each side at most.
constexpr double kLargeError = 0.1;
constexpr double kSmoothedError = 0.05;
constexpr int kMostSmoothed = 20;
/// Fewer differences of neighbours do not tell their errors.
constexpr std::size_t kFewDifferences = 30;
/// Standard deviations by which neighbours on a surface differ, at most.
constexpr double kJump = 6.0;
/// Lower quartile of the absolute values of a normal variable of unit variance.
constexpr double kQuartileOfNormal = 0.3186;

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

/// Standard deviation of the errors of ranges [m], from second differences of neighbouring rays; of
/// these, the smaller ones are not of edges.
double range_error(const std::vector<float>& ranges) {
  std::vector<double> differences;
  for (std::size_t i = 1; i + 1 < ranges.size(); ++i) {
    const double d = double(ranges[i - 1]) - 2.0 * double(ranges[i]) + double(ranges[i + 1]);
    if (std::isfinite(d)) differences.push_back(std::abs(d));
  }
  if (differences.size() < kFewDifferences) return 0.0;
  const auto quartile = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 4);
  std::nth_element(differences.begin(), quartile, differences.end());
  return *quartile / (kQuartileOfNormal * std::sqrt(6.0));
}

/// Half the number of neighbours by which ranges of that error are smoothed.
int smoothing_of(double error) {
  if (error <= kLargeError) return 0;
  const double rays = std::pow(error / kSmoothedError, 2);
  return std::min(kMostSmoothed, static_cast<int>(std::ceil(0.5 * (rays - 1.0))));
}

/// Ranges on the straight surfaces that fit their neighbours best: there, 1/r is a cos(angle) + b
/// sin(angle).
std::vector<float> smoothed(const LaserScan& scan, const std::vector<float>& ranges, double error,
                            int half) {
  std::vector<float> out = ranges;
  const auto count = static_cast<int>(ranges.size());
  const auto angle = [&](int i) { return scan.first_angle + i * scan.angle_step; };
  for (int i = 0; i < count; ++i) {
    if (!std::isfinite(ranges[i])) continue;
    Eigen::Matrix2d H = Eigen::Matrix2d::Zero();
    Eigen::Vector2d g = Eigen::Vector2d::Zero();
    const auto add = [&](int j) {
      const double r = ranges[j];
      const Eigen::Vector2d d(std::cos(angle(j)), std::sin(angle(j)));
      H += std::pow(r, 4) * d * d.transpose();
      g += std::pow(r, 3) * d;
    };
    add(i);
    for (const int side : {-1, 1}) {
      for (int n = 1; n <= half; ++n) {
        const int j = i + side * n;
        if (j < 0 || j >= count) break;
        if (!(std::abs(ranges[j] - ranges[j - side]) < kJump * error)) break;
        add(j);
      }
    }
    const Eigen::Vector2d line = H.ldlt().solve(g);
    const double inverse = line.dot(Eigen::Vector2d(std::cos(angle(i)), std::sin(angle(i))));
    const double range = 1.0 / inverse;
    if (std::abs(range - ranges[i]) < kJump * error) out[i] = static_cast<float>(range);
  }
  return out;
}

/// The ranges that tell of a surface; NaN for the others.
std::vector<float> usable_ranges(const LaserScan& scan, double max_range) {
  std::vector<float> ranges = scan.ranges;
  const double limit = std::min(max_range, scan.max_range * 0.999);
  for (float& range : ranges) {
    if (!(range >= kMinRange && range <= limit)) range = std::numeric_limits<float>::quiet_NaN();
  }
  return ranges;
}

std::vector<Return> returns_of(const LaserScan& scan, const std::vector<float>& ranges) {
  std::vector<Return> returns;
  returns.reserve(ranges.size());
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const double range = ranges[i];
    if (!std::isfinite(range)) continue;
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
  if (!is_usable(scan, options.max_range)) return {};
  std::vector<float> ranges = usable_ranges(scan, options.max_range);
  const double error = range_error(ranges);
  const int half = smoothing_of(error);
  if (half > 0) ranges = smoothed(scan, ranges, error, half);
  const std::vector<Return> returns = returns_of(scan, ranges);
  const Eigen::Vector2d sensor = planar(scan.T_robot_sensor.translation());
  const double step = std::abs(scan.angle_step);
  // Of rays that were smoothed together, few are independent.
  const double repeated = std::max(1.0, 0.5 * half);
  std::vector<SurfacePoint> points;
  int last = -1;
  for (int i = 0; i < static_cast<int>(returns.size()); ++i) {
    const double gap =
        last < 0 ? options.spacing : (returns[i].position - returns[last].position).norm();
    if (gap < options.spacing) continue;
    last = i;
    const Eigen::Vector2d normal = normal_at(returns, i, step, options.radius, sensor);
    points.push_back({returns[i].position, normal, std::min(gap, kMaxLength) / repeated});
  }
  return points;
}

std::size_t ScanView::sector(const Eigen::Vector2d& position) {
  const double turn = std::atan2(position.y(), position.x()) / (2.0 * M_PI) + 0.5;
  return std::min(static_cast<std::size_t>(turn * double(kSectors)), kSectors - 1);
}

ScanView::ScanView(const std::vector<SurfacePoint>& points) {
  for (const SurfacePoint& point : points) seen_.set(sector(point.position));
}

bool ScanView::contains(const Eigen::Vector2d& position) const {
  return position.allFinite() && seen_.test(sector(position));
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
