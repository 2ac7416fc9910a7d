// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/matrix_image.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "mrpt_plugins/drawing/axes.h"
#include "mrpt_plugins/drawing/canvas.h"
#include "mrpt_plugins/drawing/heading.h"

namespace hybrid {
namespace {

constexpr double kFrame = 900;       // pixels of the longer side of a matrix
constexpr double kShortest = 450;    // least length of the shorter side; then the scales differ
constexpr int kSmallestDot = 4;      // pixels of the sheet, which has twice the resolution
constexpr double kTextHeight = 205;  // room for the texts above a matrix
constexpr double kLeft = 140;        // room beside a matrix for the numbers of the rows
constexpr double kBetween = 40;      // between the panels
constexpr double kNarrowest = 820;   // room for the texts of a single panel

struct Size {
  int width = 0;
  int height = 0;
};

Size frame_of(const MatrixPanel& panel) {
  const double longer = std::max(panel.rows, panel.columns);
  const auto side = [longer](int n) {
    return static_cast<int>(std::lround(std::max(kShortest, kFrame * n / longer)));
  };
  return {side(panel.columns), side(panel.rows)};
}

/// First pixel, and one past the last, of entry `index` of `count`.
std::pair<int, int> reach(int index, int count, int pixels) {
  const auto at = [&](int i) { return static_cast<int>(static_cast<long>(i) * pixels / count); };
  const int from = std::min(at(index), pixels - kSmallestDot);
  return {from, std::max(at(index + 1), from + kSmallestDot)};
}

Image raster(const MatrixPanel& panel, const Size& frame) {
  Image image;
  image.width = frame.width * Canvas::kScale;
  image.height = frame.height * Canvas::kScale;
  image.rgb.assign(3 * static_cast<std::size_t>(image.width) * image.height, 255);
  for (const MatrixLayer& layer : panel.layers) {
    for (const auto& [row, column] : layer.entries) {
      if (row < 0 || row >= panel.rows || column < 0 || column >= panel.columns) {
        throw std::invalid_argument(
            fmt::format("{}: entry ({}, {}) lies outside the {} x {} matrix", panel.heading, row,
                        column, panel.rows, panel.columns));
      }
      const auto [left, right] = reach(column, panel.columns, image.width);
      const auto [top, bottom] = reach(row, panel.rows, image.height);
      for (int y = top; y < bottom; ++y) {
        std::uint8_t* pixel = &image.rgb[3 * (static_cast<std::size_t>(y) * image.width + left)];
        for (int x = left; x < right; ++x) {
          *pixel++ = layer.color.red;
          *pixel++ = layer.color.green;
          *pixel++ = layer.color.blue;
        }
      }
    }
  }
  return image;
}

/// Note about the size of the dots; empty if every entry has its true size.
std::string dot_note(const MatrixPanel& panel, const Size& frame) {
  const auto covered = [](int count, int pixels) {
    return static_cast<int>(std::ceil(double(kSmallestDot) * count / (pixels * Canvas::kScale)));
  };
  const int rows = covered(panel.rows, frame.height);
  const int columns = covered(panel.columns, frame.width);
  if (rows <= 1 && columns <= 1) return "";
  return fmt::format("a dot covers {} x {}{}", rows, columns,
                     panel.layers.size() > 1 ? ", last colour on top" : "");
}

void draw_legend(Canvas& canvas, Pixel at, const MatrixPanel& panel) {
  TextStyle style;
  style.size = 14;
  for (const MatrixLayer& layer : panel.layers) {
    canvas.marker(at + Pixel(7, 0), Marker::kSquare, 7, layer.color);
    canvas.text(at + Pixel(24, 0), layer.label, style);
    at.y() += 26;
  }
}

void draw_panel(Canvas& canvas, const Pixel& corner, const MatrixPanel& panel, const Size& frame) {
  TextStyle style;
  style.size = 14;
  style.color = palette::kMuted;
  const std::string note = dot_note(panel, frame);
  canvas.text(corner - Pixel(0, kTextHeight - 106),
              note.empty() ? panel.heading : panel.heading + "; " + note, style);
  draw_legend(canvas, corner - Pixel(0, kTextHeight - 140), panel);
  const Box box{corner.x(), corner.y(), corner.x() + frame.width, corner.y() + frame.height};
  const Axis x{panel.column_label, Scale::kLinear, {{0.0, double(panel.columns)}}};
  const Axis y{panel.row_label, Scale::kLinear, {{0.0, double(panel.rows)}}};
  Axes(box, x, y, true).draw(canvas);
  canvas.paste(raster(panel, frame), corner);
  canvas.rectangle(box, {palette::kInk, 1.5});
}

}  // namespace

Image matrix_image(const std::string& title, const std::string& subtitle,
                   const std::vector<MatrixPanel>& panels) {
  double width = 0;
  double height = 0;
  std::vector<Size> frames;
  for (const MatrixPanel& panel : panels) {
    if (panel.rows <= 0 || panel.columns <= 0) {
      throw std::invalid_argument(panel.heading + ": a matrix without entries cannot be drawn");
    }
    frames.push_back(frame_of(panel));
    width += kLeft + std::max<double>(frames.back().width, kNarrowest) + kBetween;
    height = std::max<double>(height, frames.back().height);
  }
  Canvas canvas(static_cast<int>(width), static_cast<int>(kTextHeight + height + 90));
  draw_heading(canvas, {kLeft, 36}, width - kLeft - kBetween, title, subtitle);
  double left = kLeft;
  for (std::size_t i = 0; i < panels.size(); ++i) {
    draw_panel(canvas, {left, kTextHeight}, panels[i], frames[i]);
    left += std::max<double>(frames[i].width, kNarrowest) + kBetween + kLeft;
  }
  return canvas.image();
}

}  // namespace hybrid
