// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "mrpt_plugins/drawing/axes.h"
#include "mrpt_plugins/drawing/heading.h"
#include "mrpt_plugins/drawing/labels.h"

namespace hybrid {
namespace {

constexpr double kLegendSize = 14;
constexpr double kLegendRow = 30;
constexpr double kSample = 46;  // length of the line sample in the legend
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

void check(const Series& s) {
  const auto fits = [&s](std::size_t n) { return n == 0 || n == s.x.size(); };
  if (s.x.size() != s.y.size() || !fits(s.lower.size()) || !fits(s.upper.size()) ||
      !fits(s.notes.size()) || s.lower.size() != s.upper.size()) {
    throw std::invalid_argument(fmt::format(
        "series '{}': lists of different lengths ({} x, {} y, {} lower, {} upper, {} notes)",
        s.label, s.x.size(), s.y.size(), s.lower.size(), s.upper.size(), s.notes.size()));
  }
}

bool usable(double value, Scale scale) {
  return std::isfinite(value) && (scale == Scale::kLinear || value > 0);
}

/// The axis with a range: the given one, or one that shows `values` with a little room.
Axis fitted(Axis axis, const std::vector<double>& values) {
  if (axis.range) {
    const auto [low, high] = *axis.range;
    if (!usable(low, axis.scale) || !std::isfinite(high) || !(high > low)) {
      throw std::invalid_argument(
          fmt::format("axis '{}': range [{}, {}] cannot be drawn", axis.label, low, high));
    }
    return axis;
  }
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  for (const double v : values) {
    if (!usable(v, axis.scale)) continue;
    low = std::min(low, v);
    high = std::max(high, v);
  }
  const bool log = axis.scale == Scale::kLog;
  if (!(low <= high)) low = high = 1;
  if (log) {
    const double room = std::max(1.15, std::pow(high / low, 0.04));
    axis.range = {{low / room, high * room}};
  } else {
    const double room = high > low ? 0.04 * (high - low) : std::max(1.0, 0.1 * std::abs(high));
    const bool from_zero = low >= 0 && low <= 0.3 * high && high > low;
    axis.range = {{from_zero ? 0 : low - room, high + room}};
  }
  return axis;
}

struct LegendEntry {
  const Series* series;
  Pixel at;
};

/// Places the legend's entries in rows between `left` and `right`; returns the height used.
double place_legend(const PlotSpec& spec, double left, double right, double top,
                    std::vector<LegendEntry>& entries) {
  TextStyle style;
  style.size = kLegendSize;
  double x = left;
  double y = top;
  for (const Series& s : spec.series) {
    if (s.label.empty()) continue;
    const double width = kSample + 10 + Canvas::text_extent(s.label, style).x() + 36;
    if (x > left && x + width > right) {
      x = left;
      y += kLegendRow;
    }
    entries.push_back({&s, {x, y}});
    x += width;
  }
  return entries.empty() ? 0 : y - top + kLegendRow;
}

void draw_legend(Canvas& canvas, const std::vector<LegendEntry>& entries) {
  TextStyle style;
  style.size = kLegendSize;
  for (const LegendEntry& e : entries) {
    const Series& s = *e.series;
    canvas.line(e.at, e.at + Pixel(kSample, 0), {s.color, s.width, s.line});
    canvas.marker(e.at + Pixel(kSample / 2, 0), s.marker, std::max(5.0, s.marker_radius), s.color);
    canvas.text(e.at + Pixel(kSample + 10, 0), s.label, style);
  }
}

/// The area between the ends of the error bars, a polygon for each stretch of the line.
void draw_band(Canvas& canvas, const Axes& axes, const PlotSpec& spec, const Series& s) {
  constexpr double kOpacity = 0.15;
  std::vector<Pixel> lower, upper;
  for (std::size_t i = 0; i <= s.lower.size(); ++i) {
    const bool drawn = i < s.lower.size() && usable(s.x[i], spec.x.scale) &&
                       usable(s.lower[i], spec.y.scale) && usable(s.upper[i], spec.y.scale);
    if (drawn) {
      lower.push_back(axes.pixel(s.x[i], s.lower[i]));
      upper.push_back(axes.pixel(s.x[i], s.upper[i]));
      continue;
    }
    lower.insert(lower.end(), upper.rbegin(), upper.rend());
    canvas.fill(lower, s.color, kOpacity);
    lower.clear();
    upper.clear();
  }
}

std::vector<Pixel> points_of(const Axes& axes, const PlotSpec& spec, const Series& s) {
  std::vector<Pixel> points;
  for (std::size_t i = 0; i < s.x.size(); ++i) {
    const bool seen = usable(s.x[i], spec.x.scale) && usable(s.y[i], spec.y.scale);
    points.push_back(seen ? axes.pixel(s.x[i], s.y[i]) : Pixel(kNan, kNan));
  }
  return points;
}

/// Draws the notes of all series beside their points, where there is room.
void draw_notes(Canvas& canvas, const Axes& axes, const PlotSpec& spec) {
  LabelPlacer labels(axes.box());
  for (const Series& s : spec.series) {
    const std::vector<Pixel> points = points_of(axes, spec, s);
    labels.avoid(points);
    for (std::size_t i = 0; i < points.size(); ++i) {
      labels.block(points[i], s.marker_radius);
      if (s.lower.empty() || s.band) continue;
      labels.avoid({axes.pixel(s.x[i], s.lower[i]), axes.pixel(s.x[i], s.upper[i])});
    }
  }
  TextStyle note;
  note.size = 12;
  note.halo = true;
  for (const Series& s : spec.series) {
    const std::vector<Pixel> points = points_of(axes, spec, s);
    for (std::size_t i = 0; i < s.notes.size(); ++i) {
      labels.place(canvas, points[i], s.marker_radius, s.notes[i], note);
    }
  }
}

void draw_series(Canvas& canvas, const Axes& axes, const PlotSpec& spec, const Series& s) {
  canvas.clip(axes.box());
  const std::vector<Pixel> points = points_of(axes, spec, s);
  const double edge = axes.pixel(0, spec.y.scale == Scale::kLog ? 1 : 0).y();
  if (s.band) draw_band(canvas, axes, spec, s);
  for (std::size_t i = 0; i < s.lower.size() && !s.band; ++i) {
    if (!points[i].allFinite() || !std::isfinite(s.upper[i])) continue;
    const double x = points[i].x();
    const double high = axes.pixel(s.x[i], s.upper[i]).y();
    const double low = usable(s.lower[i], spec.y.scale) ? axes.pixel(s.x[i], s.lower[i]).y() : edge;
    const Stroke bar{s.color, std::max(1.5, 0.6 * s.width)};
    canvas.line({x, low}, {x, high}, bar);
    canvas.line({x - 5, low}, {x + 5, low}, bar);
    canvas.line({x - 5, high}, {x + 5, high}, bar);
  }
  canvas.polyline(points, {s.color, s.width, s.line});
  canvas.unclip();
  for (const Pixel& p : points) {
    if (!axes.box().contains(p)) continue;
    canvas.marker(p, s.marker, s.marker_radius, s.color, s.marker_radius > 2.5);
  }
}

}  // namespace

Image render(const PlotSpec& spec) {
  std::vector<double> xs;
  std::vector<double> ys;
  for (const Series& s : spec.series) {
    check(s);
    xs.insert(xs.end(), s.x.begin(), s.x.end());
    for (const auto* list : {&s.y, &s.lower, &s.upper})
      ys.insert(ys.end(), list->begin(), list->end());
  }
  Axis x = fitted(spec.x, xs);
  Axis y = fitted(spec.y, ys);
  Canvas canvas(spec.width, spec.height);
  Box box{0, 40, spec.width - 45.0, spec.height - 90.0};
  box.left = std::max(80.0, Axes(box, x, y).left_room());
  box.top += draw_heading(canvas, {box.left, box.top}, box.width(), spec.title, spec.subtitle);
  std::vector<LegendEntry> legend;
  box.top += place_legend(spec, box.left, box.right, box.top, legend);
  draw_legend(canvas, legend);
  if (spec.equal_aspect) Axes::equalize(box, x, y);
  const Axes axes(box, x, y, spec.y_down);
  axes.draw(canvas);
  for (const Series& s : spec.series) draw_series(canvas, axes, spec, s);
  draw_notes(canvas, axes, spec);
  return canvas.image();
}

}  // namespace hybrid
