// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/mode_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "mrpt_plugins/drawing/axes.h"
#include "mrpt_plugins/drawing/canvas.h"
#include "mrpt_plugins/drawing/heading.h"
#include "mrpt_plugins/drawing/plot.h"

namespace hybrid {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr int kWidth = 1600, kHeight = 900;
constexpr double kStripHeight = 34, kStripGap = 12;
constexpr Color kUnknown{200, 200, 200};

Color color_of(int mode) {
  return mode < 0 ? kUnknown : mode_color(static_cast<std::size_t>(mode));
}

void check(const ModeTimeline& t) {
  const auto fits = [&](std::size_t size) { return size == 0 || size == t.x.size(); };
  const bool good = !t.x.empty() && fits(t.curve.size()) && fits(t.folds.size()) &&
                    std::all_of(t.strips.begin(), t.strips.end(),
                                [&](const ModeStrip& s) { return s.modes.size() == t.x.size(); });
  if (!good) throw std::invalid_argument("a timeline of modes has lists of different lengths");
}

/// Calls run(first, one past the last, mode) for stretches of equal modes.
template <class Run>
void for_each_run(const std::vector<int>& modes, Run&& run) {
  for (std::size_t i = 0; i < modes.size();) {
    std::size_t j = i + 1;
    while (j < modes.size() && modes[j] == modes[i]) ++j;
    run(i, j, modes[i]);
    i = j;
  }
}

void draw_mode_legend(Canvas& canvas, const ModeTimeline& t, double x) {
  TextStyle label;
  label.size = 14;
  for (std::size_t m = 0; m < t.mode_names.size(); ++m) {
    canvas.fill({{x, 96}, {x + 34, 96}, {x + 34, 114}, {x, 114}}, mode_color(m));
    canvas.text({x + 44, 105}, t.mode_names[m], label);
    x += 44 + Canvas::text_extent(t.mode_names[m], label).x() + 40;
  }
}

void draw_strip(Canvas& canvas, const ModeTimeline& t, const ModeStrip& strip, const Axes& axes,
                double top) {
  const double half = t.x.size() > 1 ? 0.5 * (t.x[1] - t.x[0]) : 0.5;
  for_each_run(strip.modes, [&](std::size_t i, std::size_t j, int mode) {
    const double left = axes.pixel(t.x[i] - half, 0).x();
    const double right = axes.pixel(j < t.x.size() ? t.x[j] - half : t.x[j - 1] + half, 0).x();
    const double bottom = top + kStripHeight;
    canvas.fill({{left, top}, {right, top}, {right, bottom}, {left, bottom}}, color_of(mode));
  });
  TextStyle label;
  label.size = 14;
  label.horizontal = Align::kEnd;
  canvas.text({axes.box().left - 12, top + kStripHeight / 2}, strip.label, label);
}

void draw_curve(Canvas& canvas, const ModeTimeline& t, const Axes& axes) {
  if (t.curve.empty()) return;
  canvas.clip(axes.box());
  const auto pixels = [&](std::size_t first, std::size_t last) {
    std::vector<Pixel> out;
    for (std::size_t i = first; i <= last; ++i) out.push_back(axes.pixel(t.x[i], t.curve[i]));
    return out;
  };
  for_each_run(t.strips.back().modes, [&](std::size_t i, std::size_t j, int mode) {
    if (!t.points) {
      canvas.polyline(pixels(i, std::min(j, t.x.size() - 1)), {color_of(mode), 2});
      return;
    }
    for (const Pixel& p : pixels(i, j - 1)) canvas.marker(p, Marker::kCircle, 5, color_of(mode));
  });
  canvas.unclip();
}

std::pair<double, double> range_of(const std::vector<double>& values, double rim) {
  if (values.empty()) return {0.0, 1.0};
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const double room = *high > *low ? rim * (*high - *low) : 1.0;
  return {*low - room, *high + room};
}

}  // namespace

Color mode_color(std::size_t mode) {
  return mode == 0 ? palette::kEstimate : series_color(mode == 1 ? 0 : mode);
}

Image mode_timeline_image(const ModeTimeline& t) {
  check(t);
  Canvas canvas(kWidth, kHeight);
  const double strips = static_cast<double>(t.strips.size()) * (kStripHeight + kStripGap);
  const Box box{190, 140 + strips, kWidth - 45.0, kHeight - 85.0};
  const Axes axes(box, {t.x_label, Scale::kLinear, range_of(t.x, 0.005)},
                  {t.y_label, Scale::kLinear, range_of(t.curve, 0.05)});
  draw_heading(canvas, {box.left, 36}, box.width(), t.title, t.subtitle);
  draw_mode_legend(canvas, t, box.left);
  double top = 136;
  for (const ModeStrip& strip : t.strips) {
    draw_strip(canvas, t, strip, axes, top);
    top += kStripHeight + kStripGap;
  }
  axes.draw(canvas);
  draw_curve(canvas, t, axes);
  if (!t.folds.empty()) {
    for_each_run(t.folds, [&](std::size_t i, std::size_t, int) {
      if (i == 0) return;
      const double x = axes.pixel(t.x[i], 0).x();
      canvas.line({x, 128}, {x, box.bottom}, {palette::kBlack, 2, LineStyle::kDashed});
    });
  }
  return canvas.image();
}

Image mode_path_image(const ModePath& path) {
  if (path.modes.size() != path.points.size()) {
    throw std::invalid_argument("a path of modes needs one mode per point");
  }
  PlotSpec plot;
  plot.title = path.title;
  plot.subtitle = path.subtitle;
  plot.x.label = path.x_label;
  plot.y.label = path.y_label;
  plot.equal_aspect = true;
  plot.width = 1200;
  plot.height = 1100;
  Series truth;
  truth.label = "true path";
  truth.color = palette::kTruth;
  truth.width = 6;
  for (const auto& p : path.truth) truth.x.push_back(p.x()), truth.y.push_back(p.y());
  if (!path.truth.empty()) plot.series.push_back(truth);
  for (int m = -1; m < static_cast<int>(path.mode_names.size()); ++m) {
    Series s;
    s.label = m < 0 ? "unknown" : path.mode_names[static_cast<std::size_t>(m)];
    s.color = color_of(m);
    s.width = 3;
    if (path.markers) {
      s.line = LineStyle::kNone;
      s.marker = Marker::kCircle;
      s.marker_radius = 4;
    }
    bool any = false;
    for (std::size_t i = 0; i < path.points.size(); ++i) {
      const bool here = path.modes[i] == m;
      const bool end = i > 0 && path.modes[i - 1] == m && !path.markers;  // joins the next mode
      any = any || here;
      s.x.push_back(here || end ? path.points[i].x() : kNan);
      s.y.push_back(here || end ? path.points[i].y() : kNan);
    }
    if (any) plot.series.push_back(std::move(s));
  }
  return render(plot);
}

}  // namespace hybrid
