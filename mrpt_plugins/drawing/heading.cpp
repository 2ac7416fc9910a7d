// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/heading.h"

#include <algorithm>
#include <sstream>

namespace hybrid {
namespace {

constexpr double kRow = 34;        // pixels
constexpr double kFurther = 24;    // between the rows of a subtitle
constexpr double kSmallest = 0.8;  // of the size of a subtitle

/// The factor by which the text has to be drawn smaller to fit into `room`, at most 1.
double shrinkage(const std::string& text, const TextStyle& style, double room) {
  constexpr double kRounding = 0.99;  // widths are of whole pixels of the font
  return std::min(1.0, kRounding * room / std::max(1.0, Canvas::text_extent(text, style).x()));
}

}  // namespace

std::vector<std::string> wrapped(const std::string& text, const TextStyle& style, double room) {
  std::istringstream words(text);
  std::vector<std::string> rows;
  for (std::string word; words >> word;) {
    if (!rows.empty() && Canvas::text_extent(rows.back() + ' ' + word, style).x() <= room) {
      rows.back() += ' ' + word;
    } else {
      rows.push_back(word);
    }
  }
  return rows;
}

double draw_heading(Canvas& canvas, const Pixel& at, double room, const std::string& title,
                    const std::string& subtitle) {
  double height = 0;
  TextStyle style;
  style.size = 21;
  style.bold = true;
  style.size *= shrinkage(title, style, room);
  canvas.text(at, title, style);
  if (!title.empty()) height += kRow;
  style = {};
  style.size = 14;
  style.color = palette::kMuted;
  style.size *= std::max(kSmallest, shrinkage(subtitle, style, room));
  double step = kRow;
  for (const std::string& row : wrapped(subtitle, style, room)) {
    canvas.text(at + Pixel(0, height), row, style);
    height += step;
    step = kFurther;
  }
  return height;
}

}  // namespace hybrid
