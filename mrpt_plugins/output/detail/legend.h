// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <string>

#include "mrpt_plugins/drawing/canvas.h"
#include "mrpt_plugins/mapping/map_result.h"
#include "mrpt_plugins/output/map_style.h"

namespace hybrid {

/// The legend of a map: a column of samples with texts, filled from the top.
class Legend {
 public:
  Legend(Canvas& canvas, const Pixel& top_left, double width);

  void heading(const std::string& text);
  void line(const std::string& text, const Stroke& stroke);
  void marker(const std::string& text, Marker shape, double radius, Color color);
  void ellipse(const std::string& text, Color color);
  /// Plain small text, wrapped at the column's width.
  void note(const std::string& text);
  void gap(double pixels) { at_.y() += pixels; }
  const Pixel& at() const { return at_; }

 private:
  void label(const std::string& text);

  Canvas& canvas_;
  Pixel at_;
  double width_;
};

/// The entries of a plan: paths, start and end, classes with counts, true positions.
void map_legend(Legend& legend, const MapResult& result, const GroundTruth& truth,
                const Extent& extent);

/// A bar of a round length that takes at most `room` pixels, drawn at `left`.
void scale_bar(Canvas& canvas, const Pixel& left, double pixels_per_metre, double room);

}  // namespace hybrid
