// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "libhybrid/geometry/eigen.h"
#include "mrpt_plugins/drawing/image.h"
#include "mrpt_plugins/drawing/style.h"

namespace HYBRID_API hybrid {

/// A position on a picture in pixels, x to the right, y down.
using Pixel = Eigen::Vector2d;

/// A rectangle on a picture in pixels.
struct Box {
  double left = 0, top = 0, right = 0, bottom = 0;
  double width() const { return right - left; }
  double height() const { return bottom - top; }
  bool contains(const Pixel& p) const {
    return p.x() >= left && p.x() <= right && p.y() >= top && p.y() <= bottom;
  }
};

struct Stroke {
  Color color;
  double width = 1;
  LineStyle style = LineStyle::kSolid;
};

enum class Align { kStart, kCenter, kEnd };

struct TextStyle {
  double size = 15;  ///< height of a capital letter, pixels
  Color color = palette::kInk;
  Align horizontal = Align::kStart;
  Align vertical = Align::kCenter;
  bool bold = false;
  bool upwards = false;  ///< turned a quarter to the left, for the y axis
  bool halo = false;     ///< white rim, for text over data
};

/// A white sheet to draw on, in coordinates of pixels. Points that are not finite are left out.
/// Text is UTF-8; what is none is drawn as U+FFFD. Lines along an axis and frames keep to whole
/// pixels.
class Canvas {
 public:
  Canvas(int width, int height);
  ~Canvas();

  /// Puts a picture of twice the resolution of the sheet on it, its top left at `corner`.
  void paste(const Image& doubled, const Pixel& corner);

  /// Limits the following drawing to a box, until unclip().
  void clip(const Box& box);
  void unclip();

  void line(const Pixel& a, const Pixel& b, const Stroke& stroke);
  void polyline(const std::vector<Pixel>& points, const Stroke& stroke);
  /// A filled polygon, `opacity` from 0 to 1.
  void fill(const std::vector<Pixel>& corners, Color color, double opacity = 1);
  void rectangle(const Box& box, const Stroke& stroke);
  /// A marker about 2 `radius` wide; closed shapes are filled and get a thin dark rim.
  void marker(const Pixel& center, Marker shape, double radius, Color color, bool rim = true);
  void text(const Pixel& at, const std::string& text, const TextStyle& style);

  /// Width and height that `text` takes, pixels.
  static Eigen::Vector2d text_extent(const std::string& text, const TextStyle& style);

  /// What was drawn, as pixels, and for formats of lines.
  Image image() const;

  static constexpr int kScale = 2;

 private:
  struct Sheet;
  std::unique_ptr<Sheet> sheet_;
};

/// Corners of a closed shape of the given radius around the origin; empty for kNone, kPlus, kCross.
std::vector<Pixel> marker_outline(Marker shape, double radius);

/// Points of the ellipse of `sigmas` standard deviations of a 2x2 covariance, around `center`.
std::vector<Eigen::Vector2d> covariance_ellipse(const Eigen::Vector2d& center,
                                                const Eigen::Matrix2d& covariance, double sigmas);

}  // namespace hybrid
