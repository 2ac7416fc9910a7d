// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/graph_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "mrpt_plugins/drawing/plot.h"

namespace hybrid {
namespace {

constexpr Color kClosure{213, 94, 0};
constexpr Color kRejected{150, 150, 150};
constexpr Color kLandmark = palette::kUnclassed;

Series points(const GraphDrawing::Points& points, const std::string& label, Color color) {
  Series series;
  series.label = label;
  series.color = color;
  for (const Eigen::Vector3d& p : points) {
    series.x.push_back(p.x());
    series.y.push_back(p.y());
  }
  return series;
}

/// All segments as one line, interrupted after each.
Series segments(const GraphDrawing::Segments& segments, const std::string& what,
                const Stroke& stroke) {
  const double gap = std::numeric_limits<double>::quiet_NaN();
  Series series;
  series.label = fmt::format("{} {}", segments.size(), what);
  series.color = stroke.color;
  series.width = stroke.width;
  series.line = stroke.style;
  for (const auto& [a, b] : segments) {
    series.x.insert(series.x.end(), {a.x(), b.x(), gap});
    series.y.insert(series.y.end(), {a.y(), b.y(), gap});
  }
  return series;
}

}  // namespace

Image graph_image(const GraphDrawing& graph) {
  PlotSpec plot;
  plot.title = graph.title;
  plot.subtitle = graph.subtitle;
  if (graph.is_3d) plot.subtitle += ". 3-D graph seen from above (z left out)";
  plot.x.label = "x (m)";
  plot.y.label = "y (m)";
  plot.equal_aspect = true;
  plot.width = 1500;
  plot.height = 1400;
  const double thin = graph.closures.size() > 3000 ? 0.5 : 1.0;
  if (!graph.truth.empty()) {
    plot.series.push_back(points(graph.truth, "truth", palette::kTruth));
    plot.series.back().width = 6;
  }
  if (!graph.rejected.empty()) {
    plot.series.push_back(
        segments(graph.rejected, "closures rejected", {kRejected, thin, LineStyle::kDashed}));
  }
  if (!graph.closures.empty()) {
    plot.series.push_back(segments(graph.closures, "loop closures", {kClosure, thin}));
  }
  if (!graph.odometry.empty()) {
    plot.series.push_back(segments(graph.odometry, "odometry edges", {palette::kEstimate, 2}));
  }
  Series poses = points(graph.poses, fmt::format("{} poses", graph.poses.size()), palette::kInk);
  poses.line = LineStyle::kNone;
  poses.marker = Marker::kCircle;
  poses.marker_radius = std::clamp(40.0 / std::sqrt(double(graph.poses.size() + 1)), 1.2, 4.0);
  plot.series.push_back(poses);
  if (!graph.landmarks.empty()) {
    Series landmarks =
        points(graph.landmarks, fmt::format("{} landmarks", graph.landmarks.size()), kLandmark);
    landmarks.line = LineStyle::kNone;
    landmarks.marker = Marker::kPlus;
    landmarks.marker_radius = 5;
    plot.series.push_back(landmarks);
  }
  if (!graph.poses.empty()) {
    Series start = points({graph.poses.front()}, "start", palette::kWhite);
    start.line = LineStyle::kNone;
    start.marker = Marker::kTriangle;
    start.marker_radius = 10;
    plot.series.push_back(start);
  }
  return render(plot);
}

}  // namespace hybrid
