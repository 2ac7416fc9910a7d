// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/labels.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace hybrid {
namespace {

constexpr double kCell = 3;  // pixels
constexpr double kRim = 3;   // between a text and the edge of the area, for its halo

}  // namespace

LabelPlacer::LabelPlacer(const Box& area)
    : area_(area),
      columns_(static_cast<int>(area.width() / kCell) + 1),
      rows_(static_cast<int>(area.height() / kCell) + 1),
      blocked_(static_cast<std::size_t>(columns_) * rows_, 0),
      lines_(blocked_) {}

/// First and last column and row that a box of pixels covers.
Box LabelPlacer::cells(const Box& box) const {
  const auto cell = [](double pixels, int count) {
    return std::clamp(std::floor(pixels / kCell), 0.0, count - 1.0);
  };
  return {cell(box.left - area_.left, columns_), cell(box.top - area_.top, rows_),
          cell(box.right - area_.left, columns_), cell(box.bottom - area_.top, rows_)};
}

int LabelPlacer::taken(const Grid& grid, const Box& cells) const {
  int sum = 0;
  for (int row = static_cast<int>(cells.top); row <= cells.bottom; ++row) {
    for (int column = static_cast<int>(cells.left); column <= cells.right; ++column) {
      sum += grid[static_cast<std::size_t>(row) * columns_ + column];
    }
  }
  return sum;
}

void LabelPlacer::take(Grid& grid, const Box& cells) {
  for (int row = static_cast<int>(cells.top); row <= cells.bottom; ++row) {
    for (int column = static_cast<int>(cells.left); column <= cells.right; ++column) {
      grid[static_cast<std::size_t>(row) * columns_ + column] = 1;
    }
  }
}

void LabelPlacer::block(const Pixel& p, double radius) {
  if (!area_.contains(p)) return;
  take(blocked_, cells({p.x() - radius, p.y() - radius, p.x() + radius, p.y() + radius}));
}

void LabelPlacer::avoid(const std::vector<Pixel>& line) {
  for (std::size_t i = 1; i < line.size(); ++i) {
    const double length = (line[i] - line[i - 1]).norm();
    if (!(length < 1e5)) continue;
    const int steps = static_cast<int>(length / kCell) + 1;
    for (int k = 0; k <= steps; ++k) {
      const Pixel p = line[i - 1] + (line[i] - line[i - 1]) * k / steps;
      if (area_.contains(p)) take(lines_, cells({p.x() - 2, p.y() - 2, p.x() + 2, p.y() + 2}));
    }
  }
}

bool LabelPlacer::place(Canvas& canvas, const Pixel& point, double radius, const std::string& text,
                        const TextStyle& style) {
  if (!area_.contains(point)) return false;
  const Eigen::Vector2d half = 0.5 * Canvas::text_extent(text, style);
  const double gap = radius + 3;
  const double dx = gap + half.x();
  const double dy = gap + half.y();
  const Pixel offsets[] = {{dx, 0},          {0, -dy},        {0, dy},           {-dx, 0},
                           {dx, -0.75 * dy}, {dx, 0.75 * dy}, {-dx, -0.75 * dy}, {-dx, 0.75 * dy},
                           {1.5 * dx, 0},    {0, -1.8 * dy},  {0, 1.8 * dy},     {-1.5 * dx, 0}};
  double best_cost = std::numeric_limits<double>::infinity();
  Pixel best = Pixel::Zero();
  for (std::size_t i = 0; i < std::size(offsets); ++i) {
    const Pixel c = point + offsets[i];
    const Box box{c.x() - half.x() - 2, c.y() - half.y() - 2, c.x() + half.x() + 2,
                  c.y() + half.y() + 2};
    if (!area_.contains({box.left - kRim, box.top - kRim}) ||
        !area_.contains({box.right + kRim, box.bottom + kRim})) {
      continue;
    }
    const Box place = cells(box);
    if (taken(blocked_, place) > 0) continue;
    const double cost = taken(lines_, place) + 0.3 * static_cast<double>(i);
    if (cost >= best_cost) continue;
    best_cost = cost;
    best = c;
  }
  if (!std::isfinite(best_cost)) return false;
  TextStyle centered = style;
  centered.horizontal = centered.vertical = Align::kCenter;
  canvas.text(best, text, centered);
  take(blocked_, cells({best.x() - half.x() - 2, best.y() - half.y() - 2, best.x() + half.x() + 2,
                        best.y() + half.y() + 2}));
  return true;
}

}  // namespace hybrid
