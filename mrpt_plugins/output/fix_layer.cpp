// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/detail/fix_layer.h"

#include <fmt/format.h>

#include <array>
#include <optional>

namespace hybrid {
namespace {

constexpr double kFewFixes = 500;  // of which each can be seen
constexpr double kStub = 26;       // pixels, of lines to fixes that are outside

/// How fixes of a kind are drawn.
struct FixStyle {
  const char* name;
  std::optional<FixMode> mode;
  Marker marker;
  double radius;
  Color color;
};
/// From the lowest.
constexpr std::array<FixStyle, 4> kStyles = {
    {{"not used", std::nullopt, Marker::kPlus, 4, map_style::kUnusedFix},
     {"good", FixMode::kGood, Marker::kCircle, 2.5, map_style::kGoodFix},
     {"biased", FixMode::kBiased, Marker::kTriangle, 5, map_style::kBiasedFix},
     {"false", FixMode::kFalse, Marker::kCross, 6, map_style::kFalseFix}}};

bool is_off(const FixStyle& style) {
  return style.mode && *style.mode != FixMode::kGood;
}

Pixel pixel_of(const Axes& axes, const Eigen::Vector3d& point) {
  return axes.pixel(point.x(), point.y());
}

/// From where the map says that the antenna is; to a fix that is outside, its beginning.
void draw_line(Canvas& canvas, const Pixel& antenna, const Pixel& fix, bool is_inside,
               Color color) {
  const double length = (fix - antenna).norm();
  if (!(length > 0)) return;
  const Pixel end = is_inside ? fix : Pixel(antenna + kStub / length * (fix - antenna));
  canvas.line(antenna, end, {color, 1});
}

}  // namespace

void draw_fixes(Canvas& canvas, const Axes& axes, const Box& box, const MapResult& result) {
  if (!result.datum) return;  // where they are is not known
  const double smaller = static_cast<double>(result.fixes.size()) > kFewFixes ? 0.7 : 1;
  for (const FixStyle& style : kStyles) {
    for (const FixEstimate& fix : result.fixes) {
      if (fix.mode != style.mode) continue;
      const Pixel at = pixel_of(axes, fix.measured);
      if (is_off(style)) {
        draw_line(canvas, pixel_of(axes, fix.antenna), at, box.contains(at), style.color);
      }
      canvas.marker(at, style.marker, smaller * style.radius, style.color, false);
    }
  }
}

void fix_legend(Legend& legend, const Axes& axes, const Box& box, const MapResult& result) {
  if (!result.datum) return;
  legend.heading(fmt::format("Fixes ({})", result.fixes.size()));
  std::size_t outside = 0;
  for (const FixStyle& style : kStyles) {
    std::size_t count = 0;
    for (const FixEstimate& fix : result.fixes) {
      if (fix.mode != style.mode) continue;
      ++count;
      if (!box.contains(pixel_of(axes, fix.measured))) ++outside;
    }
    if (count == 0) continue;
    legend.marker(fmt::format("{} ({})", style.name, count), style.marker, style.radius + 1,
                  style.color);
  }
  if (outside > 0) legend.note(fmt::format("{} lie outside of the picture.", outside));
}

}  // namespace hybrid
