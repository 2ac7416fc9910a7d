// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/detail/legend.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "mrpt_plugins/drawing/axes.h"
#include "mrpt_plugins/drawing/heading.h"

namespace hybrid {
namespace {

constexpr double kSample = 40;  // width of the samples
constexpr double kRow = 29;
constexpr double kText = 14;

/// The text, shortened to `room` pixels with dots at its end.
std::string shortened(std::string text, const TextStyle& style, double room) {
  if (Canvas::text_extent(text, style).x() <= room) return text;
  const auto is_inside_character = [&] { return (text.back() & 0xC0) == 0x80; };  // of UTF-8
  while (!text.empty() && Canvas::text_extent(text + "...", style).x() > room) {
    while (text.size() > 1 && is_inside_character()) text.pop_back();
    text.pop_back();
  }
  return text + "...";
}

}  // namespace

Legend::Legend(Canvas& canvas, const Pixel& top_left, double width)
    : canvas_(canvas), at_(top_left), width_(width) {}

void Legend::label(const std::string& text) {
  TextStyle style;
  style.size = kText;
  canvas_.text(at_ + Pixel(kSample + 14, 0), shortened(text, style, width_ - kSample - 14), style);
  at_.y() += kRow;
}

void Legend::heading(const std::string& text) {
  TextStyle style;
  style.size = kText + 1;
  style.bold = true;
  canvas_.text(at_, shortened(text, style, width_), style);
  at_.y() += kRow + 2;
}

void Legend::line(const std::string& text, const Stroke& stroke) {
  canvas_.line(at_, at_ + Pixel(kSample, 0), stroke);
  label(text);
}

void Legend::marker(const std::string& text, Marker shape, double radius, Color color) {
  canvas_.marker(at_ + Pixel(kSample / 2, 0), shape, radius, color);
  label(text);
}

void Legend::ellipse(const std::string& text, Color color) {
  const Eigen::Matrix2d shape = Eigen::Vector2d(17 * 17, 8 * 8).asDiagonal();
  const std::vector<Pixel> outline = covariance_ellipse(at_ + Pixel(kSample / 2, 0), shape, 1);
  canvas_.fill(outline, color, 0.25);
  canvas_.polyline(outline, {color, 1.25});
  label(text);
}

void Legend::note(const std::string& text) {
  TextStyle style;
  style.size = 12;
  style.color = palette::kMuted;
  for (const std::string& row : wrapped(text, style, width_)) {
    canvas_.text(at_, row, style);
    at_.y() += 22;
  }
}

namespace {

/// Entries of the paths, and of start and end of the estimated one.
void path_legend(Legend& legend, const MapResult& result, const GroundTruth& truth,
                 const Extent& extent) {
  legend.heading(result.robots.empty() ? "Robot path" : "Paths of the robots");
  std::set<std::string> named;
  for (const DrawnPath& robot : drawn_paths(result)) {
    if (!robot.points.empty() && named.insert(robot.name).second) {
      legend.line(robot.name, robot.stroke);
    }
  }
  if (!result.robots.empty()) {
    // Dead reckoning of several is not drawn.
  } else if (is_hidden(result.dead_reckoning, result.trajectory, extent)) {
    legend.note("Dead reckoning is hidden by the estimate.");
    legend.gap(10);
  } else if (!result.dead_reckoning.empty()) {
    legend.line("dead reckoning", map_style::kDeadReckoning);
  }
  if (!true_paths(truth).empty()) legend.line("ground truth", map_style::kTruth);
  for (std::size_t m = 1; m < result.mode_names.size(); ++m) {
    const auto count =
        std::count(result.motion_modes.begin(), result.motion_modes.end(), static_cast<int>(m));
    if (count == 0) continue;
    legend.line(fmt::format("{} ({} motions)", result.mode_names[m], count),
                map_style::mode_stroke(static_cast<int>(m)));
  }
  if (result.trajectory.empty()) return;
  legend.marker("start", Marker::kTriangle, 10, palette::kWhite);
  legend.marker("end", Marker::kSquare, 8, palette::kBlack);
}

/// Entries of the classes in use, with counts.
void class_legend(Legend& legend, const MapResult& result) {
  std::vector<std::size_t> count(result.class_names.size() + 1, 0);
  for (const LandmarkEstimate& l : result.landmarks) {
    ++count[l.class_index ? static_cast<std::size_t>(*l.class_index) : count.size() - 1];
  }
  constexpr std::size_t kMostClasses = 14;
  std::size_t shown = 0, left_out = 0;
  for (std::size_t c = 0; c < result.class_names.size(); ++c) {
    if (count[c] == 0) continue;
    if (++shown > kMostClasses) {
      ++left_out;
    } else {
      legend.marker(fmt::format("{} ({})", result.class_names[c], count[c]), class_marker(c), 8,
                    series_color(c));
    }
  }
  if (left_out > 0) legend.note(fmt::format("and {} more classes", left_out));
  if (count.back() > 0) {
    legend.marker(result.class_names.empty() ? "estimated, with id" : "class unknown",
                  Marker::kCircle, 8, palette::kUnclassed);
  }
  constexpr double kSure = 0.95;
  if (std::any_of(result.landmarks.begin(), result.landmarks.end(),
                  [](const LandmarkEstimate& l) { return class_probability(l) < kSure; })) {
    legend.note("The paler a landmark, the less probable its class.");
    legend.gap(10);
  }
}

}  // namespace

void map_legend(Legend& legend, const MapResult& result, const GroundTruth& truth,
                const Extent& extent) {
  path_legend(legend, result, truth, extent);
  legend.gap(12);
  if (lists_landmarks(result)) {
    legend.heading(fmt::format("Landmarks ({})", result.landmarks.size()));
    class_legend(legend, result);
  }
  if (result.grid) legend.line("wall, by scans or clouds", {map_style::kWall, 3});
  if (!result.movers.empty()) {
    legend.line(fmt::format("moving ({})", result.movers.size()), map_style::kMover);
  }
  if (!truth.landmarks.empty()) {
    legend.marker("true position", Marker::kPlus, 13, map_style::kTrueLandmark);
  }
}

void scale_bar(Canvas& canvas, const Pixel& left, double pixels_per_metre, double room) {
  const double metres = nice_below(room / pixels_per_metre);
  const Pixel right = left + Pixel(metres * pixels_per_metre, 0);
  const Stroke stroke{palette::kInk, 3};
  canvas.line(left, right, stroke);
  canvas.line(left + Pixel(0, -7), left + Pixel(0, 7), stroke);
  canvas.line(right + Pixel(0, -7), right + Pixel(0, 7), stroke);
  TextStyle style;
  style.horizontal = Align::kCenter;
  style.vertical = Align::kStart;
  const std::string text = metres < 1      ? fmt::format("{:g} mm", 1e3 * metres)
                           : metres >= 1e4 ? fmt::format("{:g} km", 1e-3 * metres)
                                           : fmt::format("{:g} m", metres);
  canvas.text(0.5 * (left + right) + Pixel(0, 14), text, style);
}

}  // namespace hybrid
