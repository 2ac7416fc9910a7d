// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/scene_layout.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "mrpt_plugins/drawing/axes.h"

namespace hybrid {
namespace {

constexpr double kRadians = M_PI / 180;

/// The extent rounded to whole squares of the grid, flat at height `z`.
Extent ground_of(const Extent& extent, double step, double z) {
  Extent ground;
  ground.low = step * (extent.low / step).floor();
  ground.high = step * (extent.high / step).ceil();
  ground.low.z() = ground.high.z() = z;
  return ground;
}

}  // namespace

Eigen::Vector3d SceneView::eye() const {
  const double azimuth = kRadians * azimuth_deg;
  const double elevation = kRadians * elevation_deg;
  return target + distance * Eigen::Vector3d(std::cos(azimuth) * std::cos(elevation),
                                             std::sin(azimuth) * std::cos(elevation),
                                             std::sin(elevation));
}

Pixel SceneView::project(const Eigen::Vector3d& point, double width, double height) const {
  const Eigen::Vector3d forward = (target - eye()).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  const Eigen::Vector3d ray = point - eye();
  const double depth = ray.dot(forward);
  if (!(depth > 0)) return Pixel::Constant(std::numeric_limits<double>::quiet_NaN());
  const double focal = 0.5 * height / std::tan(0.5 * kRadians * kFieldOfViewDeg);
  return {0.5 * width + focal * ray.dot(right) / depth,
          0.5 * height - focal * ray.dot(right.cross(forward)) / depth};
}

/// The view that fills the picture with the points.
SceneView view_of(const std::vector<Eigen::Vector3d>& points, double elevation_deg, double aspect) {
  SceneView view;
  view.elevation_deg = elevation_deg;
  Extent extent;
  for (const Eigen::Vector3d& point : points) extent.add(point);
  if (extent.empty()) return view;
  view.target = 0.5 * (extent.low + extent.high).matrix();
  view.distance = 4 * (extent.high - extent.low).matrix().norm();
  for (int round = 0; round < 12; ++round) {
    Eigen::Array2d low = Eigen::Array2d::Constant(1e300);
    Eigen::Array2d high = Eigen::Array2d::Constant(-1e300);
    for (const Eigen::Vector3d& point : points) {
      const Pixel p = view.project(point, aspect, 1);
      if (!p.allFinite()) continue;
      low = low.min(p.array());
      high = high.max(p.array());
    }
    const Eigen::Array2d middle = 0.5 * (low + high) - Eigen::Array2d(aspect / 2, 0.5);
    const double unit = 2 * view.distance * std::tan(0.5 * kRadians * SceneView::kFieldOfViewDeg);
    const Eigen::Vector3d forward = (view.target - view.eye()).normalized();
    const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
    view.target += unit * (middle.x() * right - middle.y() * right.cross(forward));
    constexpr double kFilled = 0.9;
    view.distance *= std::max((high - low).x() / aspect, (high - low).y()) / kFilled;
  }
  return view;
}

SceneLayout scene_layout(const MapResult& result, const GroundTruth& truth, double aspect) {
  SceneLayout layout;
  layout.frame = map_frame(result, truth);
  const Extent& extent = layout.frame.extent;
  const double size = (extent.high - extent.low).maxCoeff();
  layout.landmark_radius = 0.012 * size;
  layout.path_radius = 0.0032 * size;
  layout.wall_height = 0.012 * size;
  layout.axis_length = 0.08 * size;
  layout.grid_step = nice_below(size / 5);
  const double below = result.is_3d ? extent.low.z() - 0.02 * size : -0.003 * size;
  layout.ground = ground_of(extent, layout.grid_step, below);
  std::vector<Eigen::Vector3d> points;
  for (const double x : {layout.ground.low.x(), layout.ground.high.x()}) {
    for (const double y : {layout.ground.low.y(), layout.ground.high.y()}) {
      points.emplace_back(x, y, layout.ground.low.z());
    }
  }
  for (const LandmarkEstimate& l : result.landmarks) points.push_back(l.position);
  std::vector<Trajectory> paths = true_paths(truth);
  paths.insert(paths.begin(), result.trajectory);
  for (const Trajectory& path : paths) {
    for (const TimedPose& p : path) points.emplace_back(p.pose.x(), p.pose.y(), p.pose.z());
  }
  layout.view = view_of(points, result.is_3d ? 28 : 52, aspect);
  return layout;
}

}  // namespace hybrid
