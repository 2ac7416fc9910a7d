// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/detail/plan_view.h"

#include <cmath>

namespace hybrid {
namespace {

/// Surfaces whose normals are steeper than this are walls.
constexpr double kWall = 0.5;
/// Surfaces that are level within these cosines tell the vertical, if so large a share of all are:
/// first within 37 degrees, the last time within 11.
constexpr double kLevelWithin[] = {0.8, 0.9, 0.95, 0.98};
constexpr double kLeastLevel = 0.05;

}  // namespace

double yaw_of(const Eigen::Matrix3d& R) {
  return std::atan2(R(1, 0), R(0, 0));
}

Eigen::Matrix3d turn_about_z(double angle) {
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

Eigen::Matrix3d level_of(const SE3& pose) {
  const Eigen::Matrix3d R = pose.rotation().matrix();
  return turn_about_z(-yaw_of(R)) * R;
}

Eigen::Matrix3d levelling(const std::vector<CloudPoint>& points) {
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  for (const double within : kLevelWithin) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    std::size_t count = 0;
    for (const CloudPoint& point : points) {
      const Eigen::Vector3d normal = point.normal.cast<double>();
      const double cosine = normal.dot(up);
      if (std::abs(cosine) < within) continue;
      sum += cosine > 0 ? normal : Eigen::Vector3d(-normal);
      ++count;
    }
    if (static_cast<double>(count) < kLeastLevel * static_cast<double>(points.size()) ||
        count == 0) {
      return Eigen::Matrix3d::Identity();
    }
    up = sum.normalized();
  }
  return Eigen::Quaterniond::FromTwoVectors(up, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

std::vector<SurfacePoint> walls_of(const std::vector<CloudPoint>& points,
                                   const Eigen::Matrix3d& level) {
  std::vector<SurfacePoint> out;
  for (const CloudPoint& point : points) {
    const Eigen::Vector3d normal = level * point.normal.cast<double>();
    if (std::abs(normal.z()) > kWall) continue;
    SurfacePoint wall;
    wall.position = (level * point.position.cast<double>()).head<2>();
    if (point.has_normal()) wall.normal = normal.head<2>().normalized();
    out.push_back(wall);
  }
  return out;
}

SE3 at_best_height(const std::vector<CloudPoint>& points, const CloudSurfaces& surfaces,
                   const SE3& start, const Eigen::Vector3d& step, int steps) {
  CloudAlignmentOptions quick;
  quick.with_information = false;
  SE3 best = start;
  double most_inliers = -1;
  for (int i = 0; i <= 2 * steps; ++i) {
    const int times = i % 2 == 0 ? i / 2 : -(i + 1) / 2;
    const SE3 moved(start.translation() + times * step, start.rotation());
    const CloudAlignment found = align(points, surfaces, moved, quick);
    if (found.inliers <= most_inliers) continue;
    most_inliers = found.inliers;
    best = found.pose;
  }
  return best;
}

}  // namespace hybrid
