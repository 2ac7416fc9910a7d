// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "mrpt_plugins/drawing/canvas.h"
#include "mrpt_plugins/drawing/heading.h"
#include "mrpt_plugins/output/detail/legend.h"
#include "mrpt_plugins/output/graph_image.h"
#include "mrpt_plugins/output/scene_layout.h"

namespace hybrid {
namespace {

constexpr double kGraphLegendWidth = 310;

/// A line of the picture, and the distance of its middle from the eye [m].
struct Line {
  double depth = 0;
  Pixel from, to;
  Stroke stroke;
};

/// The colour at a depth from 0 (nearest) to 1; paler with distance.
Color in_depth(Color color, double depth) {
  constexpr double kPalest = 0.65;
  const auto mixed = [&](std::uint8_t part) {
    return static_cast<std::uint8_t>(part + kPalest * depth * (255 - part));
  };
  return {mixed(color.red), mixed(color.green), mixed(color.blue)};
}

/// The view that shows all poses, landmarks and true poses.
SceneView view_of_graph(const GraphDrawing& graph, double aspect) {
  constexpr double kElevation = 28;
  GraphDrawing::Points points = graph.poses;
  points.insert(points.end(), graph.landmarks.begin(), graph.landmarks.end());
  points.insert(points.end(), graph.truth.begin(), graph.truth.end());
  if (points.empty()) points.push_back(Eigen::Vector3d::Zero());
  constexpr double kLeast = 0.25;  // m to each side, for a graph at one point
  points.push_back(points.front() + Eigen::Vector3d::Constant(kLeast));
  points.push_back(points.front() - Eigen::Vector3d::Constant(kLeast));
  return view_of(points, kElevation, aspect);
}

/// The lines of a graph, farthest first.
std::vector<Line> lines_of(const GraphDrawing& graph, const SceneView& view, const Box& box,
                           const GraphStrokes& strokes) {
  std::vector<Line> lines;
  const Eigen::Vector3d eye = view.eye();
  const auto seen = [&](const Eigen::Vector3d& p) {
    return Pixel(Pixel(box.left, box.top) + view.project(p, box.width(), box.height()));
  };
  const auto add = [&](const GraphDrawing::Segments& segments, const Stroke& stroke) {
    for (const auto& [a, b] : segments) {
      lines.push_back({(0.5 * (a + b) - eye).norm(), seen(a), seen(b), stroke});
    }
  };
  GraphDrawing::Segments truth;
  for (std::size_t i = 1; i < graph.truth.size(); ++i) {
    truth.emplace_back(graph.truth[i - 1], graph.truth[i]);
  }
  add(truth, strokes.truth);
  add(graph.rejected, strokes.rejected);
  add(graph.closures, strokes.closures);
  add(graph.odometry, strokes.odometry);
  std::stable_sort(lines.begin(), lines.end(),
                   [](const Line& a, const Line& b) { return a.depth > b.depth; });
  return lines;
}

}  // namespace

Image graph_3d_image(const GraphDrawing& graph) {
  Canvas canvas(1600, 1200);
  const Box box{30, 95, 1600 - kGraphLegendWidth - 40, 1170};
  const SceneView view = view_of_graph(graph, box.width() / box.height());
  const GraphStrokes strokes = graph_strokes(graph);
  const std::vector<Line> lines = lines_of(graph, view, box, strokes);
  canvas.clip(box);
  for (const Line& line : lines) {
    const double nearest = lines.back().depth, farthest = lines.front().depth;
    Stroke stroke = line.stroke;
    stroke.color = in_depth(stroke.color,
                            farthest > nearest ? (line.depth - nearest) / (farthest - nearest) : 0);
    canvas.line(line.from, line.to, stroke);
  }
  const auto mark = [&](const Eigen::Vector3d& p, Marker shape, double radius, Color color) {
    canvas.marker(Pixel(box.left, box.top) + view.project(p, box.width(), box.height()), shape,
                  radius, color);
  };
  for (const Eigen::Vector3d& p : graph.landmarks) mark(p, Marker::kPlus, 5, palette::kUnclassed);
  if (!graph.poses.empty()) mark(graph.poses.front(), Marker::kTriangle, 10, palette::kWhite);
  canvas.unclip();
  draw_heading(canvas, {40, 36}, 1600 - 2 * 40, graph.title + " in 3-D",
               graph.subtitle + ". Seen from above at a slant; paler is farther away");
  Legend legend(canvas, {box.right + 20, box.top + 14}, kGraphLegendWidth);
  legend.heading(fmt::format("Poses ({})", graph.poses.size()));
  const auto entry = [&](std::size_t count, const char* what, const Stroke& stroke) {
    if (count > 0) legend.line(fmt::format("{} {}", count, what), stroke);
  };
  entry(graph.odometry.size(), "odometry edges", strokes.odometry);
  entry(graph.closures.size(), "loop closures", strokes.closures);
  entry(graph.rejected.size(), "closures rejected", strokes.rejected);
  if (!graph.truth.empty()) legend.line("truth", strokes.truth);
  if (!graph.poses.empty()) legend.marker("start", Marker::kTriangle, 10, palette::kWhite);
  if (!graph.landmarks.empty()) {
    legend.marker(fmt::format("{} landmarks", graph.landmarks.size()), Marker::kPlus, 8,
                  palette::kUnclassed);
  }
  return canvas.image();
}

}  // namespace hybrid
