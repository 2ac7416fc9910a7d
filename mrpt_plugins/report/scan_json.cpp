// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/report/scan_json.h"

#include <nlohmann/json.hpp>

#include "libhybrid/scans/scan_points.h"
#include "mrpt_plugins/report/columns.h"
#include "mrpt_plugins/report/detail/closure_columns.h"

namespace hybrid {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kUnit = 0.01;     // m, of coordinates
constexpr double kSpacing = 0.1;   // m, between points
constexpr double kMostRange = 30;  // m

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
