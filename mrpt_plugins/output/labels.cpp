// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/output/labels.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace hybrid {
namespace {

constexpr double kCell = 3;  // pixels

}  // namespace

LabelPlacer::LabelPlacer(const Box& area)
    : area_(area),
      blocked_(cv::Mat::zeros(static_cast<int>(area.height() / kCell) + 1,
                              static_cast<int>(area.width() / kCell) + 1, CV_8UC1)),
      lines_(blocked_.clone()) {}

cv::Rect LabelPlacer::cells(const Box& box) const {
  const auto cell = [](double v) { return static_cast<int>(std::floor(v / kCell)); };
  return cv::Rect(cv::Point(cell(box.left - area_.left), cell(box.top - area_.top)),
                  cv::Point(cell(box.right - area_.left) + 1, cell(box.bottom - area_.top) + 1)) &
         cv::Rect(0, 0, blocked_.cols, blocked_.rows);
}

void LabelPlacer::block(const Pixel& p, double radius) {
  if (!area_.contains(p)) return;
  blocked_(cells({p.x() - radius, p.y() - radius, p.x() + radius, p.y() + radius})).setTo(1);
}

void LabelPlacer::avoid(const std::vector<Pixel>& line) {
  std::vector<cv::Point> points;
  for (const Pixel& p : line) {
    if (!area_.contains(p)) continue;
    points.emplace_back(static_cast<int>((p.x() - area_.left) / kCell),
                        static_cast<int>((p.y() - area_.top) / kCell));
  }
  cv::polylines(lines_, points, false, cv::Scalar(1), 2);
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
    if (!area_.contains({box.left, box.top}) || !area_.contains({box.right, box.bottom})) continue;
    const cv::Rect place = cells(box);
    if (cv::countNonZero(blocked_(place)) > 0) continue;
    const double cost = cv::countNonZero(lines_(place)) + 0.3 * static_cast<double>(i);
    if (cost >= best_cost) continue;
    best_cost = cost;
    best = c;
  }
  if (!std::isfinite(best_cost)) return false;
  TextStyle centered = style;
  centered.horizontal = centered.vertical = Align::kCenter;
  canvas.text(best, text, centered);
  blocked_(cells({best.x() - half.x() - 2, best.y() - half.y() - 2, best.x() + half.x() + 2,
                  best.y() + half.y() + 2}))
      .setTo(1);
  return true;
}

}  // namespace hybrid
