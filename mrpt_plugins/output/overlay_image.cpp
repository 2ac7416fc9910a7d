// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/overlay_image.h"

#include <fmt/format.h>

#include <algorithm>

#include "mrpt_plugins/drawing/axes.h"
#include "mrpt_plugins/drawing/canvas.h"
#include "mrpt_plugins/drawing/heading.h"

namespace hybrid {
namespace {

constexpr std::size_t kShown = 8000;  // most points of a cloud in a panel
constexpr Color kTarget = palette::kDeadReckoning;
constexpr Color kSource = palette::kEstimate;

struct View {
  int x, y;  // axes to the right and up
  const char* name;
};

constexpr View kViews[] = {{0, 1, "along z"}, {0, 2, "along y"}, {1, 2, "along x"}};

Points thinned(const Points& points) {
  const std::size_t step = (points.size() + kShown - 1) / kShown;
  Points few;
  for (std::size_t i = 0; i < points.size(); i += step) few.push_back(points[i]);
  return few;
}

Points moved(const SE3& T, Points points) {
  for (Eigen::Vector3d& p : points) p = T * p;
  return points;
}

Axis axis(const Eigen::AlignedBox3d& bounds, int index, const std::string& unit) {
  const double room = std::max(1e-6, 0.04 * bounds.sizes().maxCoeff());
  Axis result;
  result.label = fmt::format("{} ({})", "xyz"[index], unit);
  result.range = {{bounds.min()[index] - room, bounds.max()[index] + room}};
  return result;
}

/// Draws points on whole pixels: equal dots make a small file.
void scatter(Canvas& canvas, const Axes& axes, const View& view, const Points& points, Color color,
             double radius) {
  for (const Eigen::Vector3d& p : points) {
    const Pixel dot = axes.pixel(p[view.x], p[view.y]).array().round();
    canvas.marker(dot, Marker::kSquare, radius, color, false);
  }
}

Axes axes_of(const Box& box, const View& view, const Eigen::AlignedBox3d& bounds,
             const std::string& unit) {
  Axis x = axis(bounds, view.x, unit), y = axis(bounds, view.y, unit);
  Axes::equalize(box, x, y);
  return Axes(box, x, y);
}

void draw_panel(Canvas& canvas, const Axes& axes, const View& view, const std::string& heading,
                const Points& target, const Points& source) {
  const Box& box = axes.box();
  axes.draw(canvas);
  const double radius = target.size() + source.size() < 3000 ? 2.0 : 0.5;
  canvas.clip(box);
  scatter(canvas, axes, view, target, kTarget, radius);
  scatter(canvas, axes, view, source, kSource, radius);
  canvas.unclip();
  TextStyle style;
  style.size = 15;
  style.bold = true;
  canvas.text({box.left, box.top - 16}, heading, style);
}

void draw_head(Canvas& canvas, int width, const Overlay& overlay, bool thinned_any) {
  draw_heading(canvas, {105, 40}, width - 2 * 105, overlay.title, overlay.note);
  TextStyle style;
  style.size = 14;
  double left = 113;
  const auto entry = [&](const std::string& text, Color color) {
    canvas.marker({left, 106}, Marker::kSquare, 7, color);
    canvas.text({left + 18, 106}, text, style);
    left += 60 + Canvas::text_extent(text, style).x();
  };
  const std::string note = thinned_any ? fmt::format(", at most {} drawn", kShown) : "";
  entry(fmt::format("target, {} points{}", overlay.target.size(), note), kTarget);
  entry(fmt::format("source, {} points{}", overlay.source.size(), note), kSource);
}

}  // namespace

Image overlay_image(const Overlay& overlay) {
  const Points target = thinned(overlay.target), source = thinned(overlay.source);
  const Points sources[] = {moved(overlay.before, source), moved(overlay.after, source)};
  const auto itself = [](const Eigen::Vector3d& p) { return p; };
  Eigen::AlignedBox3d bounds = box_of(target, itself);
  const Eigen::Vector3d size = bounds.sizes();
  for (const Points& points : sources) bounds.extend(box_of(points, itself));
  const bool flat = size.z() <= 1e-6 * size.maxCoeff();
  const int views = flat ? 1 : 3;

  // Flat clouds have two panels side by side, others two rows.
  const int width = 1800, height = flat ? 960 : 1280;
  Canvas canvas(width, height);
  draw_head(canvas, width, overlay,
            target.size() < overlay.target.size() || source.size() < overlay.source.size());
  const int columns = flat ? 2 : 3, rows = flat ? 1 : 2;
  const double top = 170, cell_width = (width - 20.0) / columns;
  const double cell_height = (height - top) / rows;
  for (int state = 0; state < 2; ++state) {
    for (int v = 0; v < views; ++v) {
      const double left = (flat ? state : v) * cell_width;
      const double upper = top + (flat ? 0 : state) * cell_height;
      const Box box{left + 105, upper, left + cell_width - 15, upper + cell_height - 115};
      const std::string heading =
          fmt::format("{}, seen {}", state == 0 ? "Before" : "After", kViews[v].name);
      draw_panel(canvas, axes_of(box, kViews[v], bounds, overlay.unit), kViews[v], heading, target,
                 sources[state]);
    }
  }
  return canvas.image();
}

}  // namespace hybrid
