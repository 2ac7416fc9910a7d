// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/scan_json.h"

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libhybrid/scans/scan_points.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "mrpt_plugins/report/columns.h"
#include "mrpt_plugins/report/detail/closure_columns.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kUnit = 0.01;     // m, of coordinates
constexpr double kSpacing = 0.1;   // m, between points
constexpr double kMostRange = 30;  // m
constexpr double kUpright = 0.5;   // of a unit normal, upwards, at most

std::vector<SurfacePoint> points_of(const KeyframeScans& at) {
  ScanPointOptions options;
  options.spacing = kSpacing;
  options.max_range = kMostRange;
  std::vector<SurfacePoint> points;
  for (const LaserScan* scan : at.scans) {
    const std::vector<SurfacePoint> seen = scan_points(*scan, options);
    points.insert(points.end(), seen.begin(), seen.end());
  }
  return points;
}

/// Walls and poles of a view, relative to its anchor, in a level frame with the heading of that.
std::vector<Eigen::Vector3d> walls_of(const LocalView& view,
                                      const Eigen::Isometry3d& T_map_anchor) {
  const Eigen::Matrix3d R = T_map_anchor.linear();
  const double yaw = std::atan2(R(1, 0), R(0, 0));
  const Eigen::Matrix3d level = Eigen::AngleAxisd(-yaw, Eigen::Vector3d::UnitZ()) * R;
  std::vector<Eigen::Vector3d> out;
  for (const CloudPoint& point : view.points) {
    if (std::abs(level.row(2).dot(point.normal.cast<double>())) > kUpright) continue;
    out.emplace_back(level * point.position.cast<double>());
  }
  return out;
}

}  // namespace

Json scans_json(const std::vector<KeyframeScans>& scans, std::size_t most_points) {
  std::vector<std::vector<SurfacePoint>> points;
  std::size_t count = 0;
  for (const KeyframeScans& at : scans) {
    points.push_back(points_of(at));
    count += points.back().size();
  }
  const std::size_t every = 1 + count / (most_points + 1);
  Json list = Json::array();
  for (std::size_t i = 0; i < scans.size(); ++i) {
    std::vector<double> x, y;
    for (std::size_t n = 0; n < points[i].size(); n += every) {
      x.push_back(points[i][n].position.x());
      y.push_back(points[i][n].position.y());
    }
    if (x.empty()) continue;
    list.push_back(
        {{"k", scans[i].keyframe}, {"x", steps_of(x, 0, kUnit)}, {"y", steps_of(y, 0, kUnit)}});
  }
  return {{"unit", kUnit}, {"list", list}};
}

Json views_json(const std::vector<LocalView>& views, const Trajectory& keyframes,
                std::size_t most_points) {
  std::vector<std::vector<Eigen::Vector3d>> walls;
  std::size_t count = 0;
  for (const LocalView& view : views) {
    walls.push_back(walls_of(view, to_isometry(keyframes[view.anchor].pose)));
    count += walls.back().size();
  }
  const std::size_t every = 1 + count / (most_points + 1);
  Json list = Json::array();
  for (std::size_t i = 0; i < views.size(); ++i) {
    std::array<std::vector<double>, 3> axes;
    for (std::size_t n = 0; n < walls[i].size(); n += every) {
      for (int axis = 0; axis < 3; ++axis) axes[axis].push_back(walls[i][n][axis]);
    }
    if (axes[0].empty()) continue;
    list.push_back({{"k", views[i].anchor},
                    {"x", steps_of(axes[0], 0, kUnit)},
                    {"y", steps_of(axes[1], 0, kUnit)},
                    {"z", steps_of(axes[2], 0, kUnit)}});
  }
  return {{"unit", kUnit}, {"list", list}};
}

Json scan_closures_json(const std::vector<ScanClosureEstimate>& closures) {
  Json out = closure_columns(closures);
  out.update(empty_columns({"inliers", "modes"}));
  for (const ScanClosureEstimate& closure : closures) {
    out["inliers"].push_back(digits(closure.inliers));
    out["modes"].push_back(closure.modes);
  }
  return out;
}

}  // namespace hybrid
