// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/cloud_points.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>

#include "libhybrid/clouds/grid_cell.h"

namespace hybrid {
namespace {

constexpr float kFarthest = 1000;                     // m
constexpr std::size_t kFewPoints = 100;               // tell no scale
constexpr std::size_t kScalePoints = 2000;            // tell it
constexpr double kLeastReach = 0.5, kMostReach = 30;  // m
/// Fewer points around tell no normal.
constexpr int kFewAround = 5;
/// Across the rays, the smaller variance of the points of a surface is at least this share of the
/// larger one. Else they are a line, as the returns of one ring are, and noise along the rays would
/// choose a normal.
constexpr double kLine = 0.01;
/// The least variance of the points of a surface is at most this share of the middle one.
constexpr double kRough = 0.15;

/// Sums over the points of a cube.
struct Sums {
  double count = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();    // sum of the points, then their mean
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();  // sum of p p'
};

struct Plane {
  Eigen::Vector3d point = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
};

/// The smaller variance across a ray, as a share of the larger one.
double spread_across(const Eigen::Matrix3d& covariance, const Eigen::Vector3d& ray) {
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = ray.unitOrthogonal();
  across.col(1) = ray.normalized().cross(across.col(0));
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
  eigen.computeDirect(across.transpose() * covariance * across, Eigen::EigenvaluesOnly);
  return eigen.eigenvalues()[0] / eigen.eigenvalues()[1];
}

/// The plane of points near each other, whose normal looks at the origin; a zero normal where they
/// are no surface.
Plane plane_of(const Sums& around) {
  Plane out;
  if (around.count < kFewAround) return out;
  out.point = around.mean / around.count;
  const Eigen::Matrix3d C = around.square / around.count - out.point * out.point.transpose();
  if (!(spread_across(C, out.point) > kLine)) return out;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen;
  eigen.computeDirect(C);
  if (!(eigen.eigenvalues()[0] < kRough * eigen.eigenvalues()[1])) return out;
  const Eigen::Vector3d normal = eigen.eigenvectors().col(0);
  out.normal = normal.dot(out.point) > 0 ? Eigen::Vector3d(-normal) : normal;
  return out;
}

}  // namespace

double reach_of(const std::vector<Eigen::Vector3f>& points, const Eigen::Vector3f& sensor) {
  std::vector<float> ranges;
  const std::size_t step = std::max<std::size_t>(1, points.size() / kScalePoints);
  for (std::size_t i = 0; i < points.size(); i += step) {
    const float range = (points[i] - sensor).norm();
    if (range > 0 && range < kFarthest) ranges.push_back(range);
  }
  if (ranges.size() < kFewPoints) return 0;
  const auto middle = ranges.begin() + static_cast<std::ptrdiff_t>(ranges.size() / 2);
  std::nth_element(ranges.begin(), middle, ranges.end());
  return std::clamp<double>(*middle, kLeastReach, kMostReach);
}

std::vector<CloudPoint> cloud_points(const std::vector<Eigen::Vector3f>& points,
                                     const Eigen::Vector3f& sensor, double spacing) {
  std::unordered_map<GridCell, std::uint32_t, GridCellHash> index;
  std::vector<GridCell> cells;
  std::vector<Sums> sums;
  index.reserve(points.size() / 4);
  for (const Eigen::Vector3f& p : points) {
    if (!((p - sensor).norm() < kFarthest)) continue;
    const Eigen::Vector3d d = (p - sensor).cast<double>();  // near 0, for the squares
    const GridCell cell = grid_cell(d, spacing);
    const auto [found, is_new] = index.emplace(cell, static_cast<std::uint32_t>(sums.size()));
    if (is_new) {
      cells.push_back(cell);
      sums.emplace_back();
    }
    Sums& sum = sums[found->second];
    ++sum.count;
    sum.mean += d;
    sum.square += d * d.transpose();
  }
  std::vector<CloudPoint> out(sums.size());
  for (std::size_t i = 0; i < sums.size(); ++i) {
    Sums around;
    for (const GridCell& step : cells_around()) {
      const auto found = index.find(cells[i] + step);
      if (found == index.end()) continue;
      const Sums& other = sums[found->second];
      around.count += other.count;
      around.mean += other.mean;
      around.square += other.square;
    }
    const Plane plane = plane_of(around);
    const Eigen::Vector3d mean = sums[i].mean / sums[i].count;
    const Eigen::Vector3d flat = mean - plane.normal * plane.normal.dot(mean - plane.point);
    out[i].position = flat.cast<float>() + sensor;
    out[i].normal = plane.normal.cast<float>();
  }
  return out;
}

std::vector<CloudPoint> transformed(const SE3& T, const std::vector<CloudPoint>& points) {
  const Eigen::Matrix3f R = T.rotation().matrix().cast<float>();
  const Eigen::Vector3f t = T.translation().cast<float>();
  std::vector<CloudPoint> out;
  out.reserve(points.size());
  for (const CloudPoint& point : points) out.push_back({R * point.position + t, R * point.normal});
  return out;
}

Eigen::Vector3d middle_of(const std::vector<CloudPoint>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const CloudPoint& point : points) sum += point.position.cast<double>();
  return sum / static_cast<double>(std::max<std::size_t>(points.size(), 1));
}

}  // namespace hybrid
