// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/canvas.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "mrpt_plugins/drawing/detail/drawing.h"
#include "mrpt_plugins/drawing/detail/font.h"

namespace hybrid {
namespace {

constexpr double kFarAway = 1e5;  // pixels; Cairo's coordinates are of fixed point

double shift(Align align, double extent) {
  return align == Align::kStart ? 0 : align == Align::kCenter ? -0.5 * extent : -extent;
}

Pixel limited(const Pixel& p) {
  return p.array().max(-kFarAway).min(kFarAway);
}

/// The middle of a line of the given width next to `at` whose edges are those of pixels.
double snapped(double at, double width) {
  const bool is_odd = std::lround(std::max(1.0, width)) % 2 == 1;
  return is_odd ? std::floor(at) + 0.5 : std::round(at);
}

}  // namespace

struct Canvas::Sheet {
  Sheet(int width, int height)
      : drawing(std::make_shared<Drawing>(width, height)),
        context(cairo_create(drawing->surface())) {
    cairo::check(cairo_status(pen()));
    cairo_save(pen());
  }

  cairo_t* pen() const { return context.get(); }

  void ink(Color color, double opacity = 1) const {
    constexpr double kFull = 255;
    cairo_set_source_rgba(pen(), color.red / kFull, color.green / kFull, color.blue / kFull,
                          opacity);
  }

  void move_to(const Pixel& p) const { cairo_move_to(pen(), limited(p).x(), limited(p).y()); }
  void line_to(const Pixel& p) const { cairo_line_to(pen(), limited(p).x(), limited(p).y()); }

  /// Sets the pen for a line that begins `travelled` pixels after the first dash.
  void take(const Stroke& stroke, double travelled = 0) const {
    ink(stroke.color);
    cairo_set_line_width(pen(), stroke.width);
    cairo_set_line_cap(pen(), CAIRO_LINE_CAP_ROUND);
    cairo_set_line_join(pen(), CAIRO_LINE_JOIN_ROUND);
    const bool is_dashed = stroke.style == LineStyle::kDashed;
    const double dashes[] = {stroke.width * (is_dashed ? 4.5 : 0.1),
                             stroke.width * (is_dashed ? 3 : 2.2)};
    cairo_set_dash(pen(), dashes, stroke.style == LineStyle::kSolid ? 0 : 2, travelled);
  }

  /// Points without a gap. Long lines are drawn in pieces, since what Cairo needs for one grows
  /// with the square of its crossings.
  void connected(const Pixel* points, std::size_t count, const Stroke& stroke) const {
    constexpr std::size_t kPiece = 200;
    double travelled = 0;
    for (std::size_t first = 0; first == 0 || first + 1 < count; first += kPiece) {
      take(stroke, travelled);
      move_to(points[first]);
      if (count == 1) line_to(points[first]);
      const std::size_t last = std::min(first + kPiece, count - 1);
      for (std::size_t i = first + 1; i <= last; ++i) {
        line_to(points[i]);
        travelled += (limited(points[i]) - limited(points[i - 1])).norm();
      }
      cairo_stroke(pen());
    }
  }

  std::shared_ptr<Drawing> drawing;
  cairo::Context context;
};

Canvas::Canvas(int width, int height) : sheet_(std::make_unique<Sheet>(width, height)) {}

Canvas::~Canvas() = default;

void Canvas::paste(const Image& doubled, const Pixel& corner) {
  const cairo::Surface pixels = cairo::surface_of(doubled);
  cairo_t* pen = sheet_->pen();
  cairo_save(pen);
  cairo_translate(pen, corner.x(), corner.y());
  cairo_scale(pen, 1.0 / kScale, 1.0 / kScale);
  cairo_set_source_surface(pen, pixels.get(), 0, 0);
  cairo_rectangle(pen, 0, 0, doubled.width, doubled.height);
  cairo_fill(pen);
  cairo_restore(pen);
}

void Canvas::clip(const Box& box) {
  unclip();
  cairo_rectangle(sheet_->pen(), std::round(box.left), std::round(box.top),
                  std::round(box.right) - std::round(box.left),
                  std::round(box.bottom) - std::round(box.top));
  cairo_clip(sheet_->pen());
}

void Canvas::unclip() {
  cairo_restore(sheet_->pen());
  cairo_save(sheet_->pen());
}

void Canvas::line(const Pixel& a, const Pixel& b, const Stroke& stroke) {
  const bool is_level = a.y() == b.y();
  if (stroke.style != LineStyle::kSolid || is_level == (a.x() == b.x())) {
    polyline({a, b}, stroke);
    return;
  }
  if (!a.allFinite() || !b.allFinite()) return;
  sheet_->take(stroke);
  cairo_set_line_cap(sheet_->pen(), CAIRO_LINE_CAP_BUTT);
  const double middle = snapped(is_level ? a.y() : a.x(), stroke.width);
  sheet_->move_to(is_level ? Pixel(a.x(), middle) : Pixel(middle, a.y()));
  sheet_->line_to(is_level ? Pixel(b.x(), middle) : Pixel(middle, b.y()));
  cairo_stroke(sheet_->pen());
}

void Canvas::polyline(const std::vector<Pixel>& points, const Stroke& stroke) {
  if (stroke.style == LineStyle::kNone) return;
  for (std::size_t first = 0; first < points.size(); ++first) {
    std::size_t end = first;
    while (end < points.size() && points[end].allFinite()) ++end;
    if (end > first) sheet_->connected(&points[first], end - first, stroke);
    first = end;
  }
}

void Canvas::fill(const std::vector<Pixel>& corners, Color color, double opacity) {
  for (const Pixel& p : corners) {
    if (!p.allFinite()) return;
  }
  sheet_->ink(color, opacity);
  for (const Pixel& p : corners) sheet_->line_to(p);
  cairo_fill(sheet_->pen());
}

void Canvas::rectangle(const Box& box, const Stroke& stroke) {
  const double left = snapped(box.left, stroke.width);
  const double top = snapped(box.top, stroke.width);
  sheet_->take(stroke);
  cairo_set_line_join(sheet_->pen(), CAIRO_LINE_JOIN_MITER);
  cairo_rectangle(sheet_->pen(), left, top, snapped(box.right, stroke.width) - left,
                  snapped(box.bottom, stroke.width) - top);
  cairo_stroke(sheet_->pen());
}

void Canvas::marker(const Pixel& center, Marker shape, double radius, Color color, bool rim) {
  if (!center.allFinite()) return;
  if (shape == Marker::kPlus || shape == Marker::kCross) {
    const double r = shape == Marker::kPlus ? radius : radius * M_SQRT1_2;
    const Pixel a = shape == Marker::kPlus ? Pixel(r, 0) : Pixel(r, r);
    const Pixel b = shape == Marker::kPlus ? Pixel(0, r) : Pixel(r, -r);
    const Stroke stroke{color, std::max(1.0, 0.12 * radius)};
    line(center - a, center + a, stroke);
    line(center - b, center + b, stroke);
    return;
  }
  std::vector<Pixel> corners = marker_outline(shape, radius);
  if (corners.empty()) return;
  for (Pixel& p : corners) p += center;
  fill(corners, color);
  corners.push_back(corners.front());
  if (rim) polyline(corners, {palette::kInk, std::max(0.75, 0.1 * radius)});
}

Eigen::Vector2d Canvas::text_extent(const std::string& text, const TextStyle& style) {
  const Eigen::Vector2d extent(font::width(text, style.size, style.bold), style.size);
  return style.upwards ? Eigen::Vector2d(extent.y(), extent.x()) : extent;
}

void Canvas::text(const Pixel& at, const std::string& text, const TextStyle& style) {
  if (text.empty() || !at.allFinite()) return;
  const Eigen::Vector2d extent = text_extent(text, style);
  const Pixel corner =
      at + Pixel(shift(style.horizontal, extent.x()), shift(style.vertical, extent.y()));
  cairo_t* pen = sheet_->pen();
  cairo_save(pen);
  cairo_translate(pen, corner.x() + (style.upwards ? style.size : 0), corner.y() + extent.y());
  if (style.upwards) cairo_rotate(pen, -M_PI / 2);
  if (style.halo) {
    constexpr double kRim = 0.22;  // of the height of a capital letter
    cairo_move_to(pen, 0, 0);
    font::add_outline(pen, text, style.size, style.bold);
    sheet_->take({palette::kWhite, 2 * kRim * style.size});
    cairo_stroke(pen);
  }
  cairo_move_to(pen, 0, 0);
  sheet_->ink(style.color);
  font::draw(pen, text, style.size, style.bold);
  cairo_new_path(pen);  // the end of the text is no corner of what is filled next
  cairo_restore(pen);
}

Image Canvas::image() const {
  cairo::check(cairo_status(sheet_->pen()));
  Image image = sheet_->drawing->pixels();
  image.drawing = sheet_->drawing;
  return image;
}

std::string png(const Image& image) {
  std::string out;
  cairo::check(
      cairo_surface_write_to_png_stream(cairo::surface_of(image).get(), cairo::append, &out));
  return out;
}

std::string encoded(const Image& image, PictureFormat format) {
  if (format == PictureFormat::kPng) return png(image);
  if (image.drawing) return image.drawing->file(format);
  Canvas sheet(image.width / Canvas::kScale, image.height / Canvas::kScale);
  sheet.paste(image, Pixel::Zero());
  return encoded(sheet.image(), format);
}

std::vector<Pixel> marker_outline(Marker shape, double radius) {
  int corners = 0;
  double first = -M_PI / 2;  // a corner at the top
  double inner = 1;
  switch (shape) {
    case Marker::kNone:
    case Marker::kPlus:
    case Marker::kCross:
      return {};
    case Marker::kCircle:
      corners = 40;
      radius *= 0.92;
      break;
    case Marker::kSquare:
      corners = 4;
      first = -M_PI / 4;
      radius *= 1.2;
      break;
    case Marker::kTriangle:
      corners = 3;
      radius *= 1.3;
      break;
    case Marker::kDiamond:
      corners = 4;
      radius *= 1.2;
      break;
    case Marker::kPentagon:
      corners = 5;
      radius *= 1.1;
      break;
    case Marker::kStar:
      corners = 10;
      radius *= 1.4;
      inner = 0.45;
      break;
  }
  std::vector<Pixel> out;
  for (int i = 0; i < corners; ++i) {
    const double angle = first + 2 * M_PI * i / corners;
    out.push_back(radius * (i % 2 == 1 ? inner : 1.0) * Pixel(std::cos(angle), std::sin(angle)));
  }
  return out;
}

std::vector<Eigen::Vector2d> covariance_ellipse(const Eigen::Vector2d& center,
                                                const Eigen::Matrix2d& covariance, double sigmas) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance);
  const Eigen::Matrix2d axes =
      sigmas * eigen.eigenvectors() *
      eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal().toDenseMatrix();
  std::vector<Eigen::Vector2d> out;
  constexpr int kPoints = 64;
  for (int i = 0; i <= kPoints; ++i) {
    const double angle = 2 * M_PI * i / kPoints;
    out.push_back(center + axes * Eigen::Vector2d(std::cos(angle), std::sin(angle)));
  }
  return out;
}

}  // namespace hybrid
