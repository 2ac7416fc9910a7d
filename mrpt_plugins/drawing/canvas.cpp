// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/canvas.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace hybrid {
namespace {

constexpr int kFractionBits = 4;
constexpr double kFarAway = 1e5;   // pixels; limits fixed-point coordinates to the range of int
constexpr double kCapHeight = 21;  // of the font at scale 1
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;

cv::Scalar bgr(Color c) {
  return {double(c.blue), double(c.green), double(c.red)};
}

int thickness(double pixels) {
  return std::max(1, static_cast<int>(std::lround(pixels * Canvas::kScale)));
}

double font_scale(const TextStyle& style) {
  return style.size * Canvas::kScale / kCapHeight;
}

int font_thickness(const TextStyle& style) {
  return thickness(style.size * (style.bold ? 0.17 : 0.105));
}

double shift(Align align, double extent) {
  return align == Align::kStart ? 0 : align == Align::kCenter ? -0.5 * extent : -extent;
}

/// Mixes `color` into `target` where the mask is set.
void blend(cv::Mat target, const cv::Mat& mask, Color color) {
  const int value[3] = {color.blue, color.green, color.red};
  for (int y = 0; y < target.rows; ++y) {
    auto* pixel = target.ptr<cv::Vec3b>(y);
    const auto* weight = mask.ptr<std::uint8_t>(y);
    for (int x = 0; x < target.cols; ++x) {
      for (int c = 0; c < 3; ++c) {
        const int mixed = pixel[x][c] * (255 - weight[x]) + value[c] * weight[x];
        pixel[x][c] = static_cast<std::uint8_t>((mixed + 127) / 255);
      }
    }
  }
}

}  // namespace

/// The picture at twice its size, and the clipped view of it.
struct Canvas::Sheet {
  cv::Mat all;  // BGR
  cv::Mat window;
  Pixel origin = Pixel::Zero();  // corner of the window, in `all`

  std::vector<cv::Point> fixed_point(const std::vector<Pixel>& points) const {
    std::vector<cv::Point> out;
    out.reserve(points.size());
    for (const Pixel& p : points) {
      const Pixel q = ((p * kScale - origin).array() - 0.5).max(-kFarAway).min(kFarAway);
      out.emplace_back(static_cast<int>(std::lround(q.x() * (1 << kFractionBits))),
                       static_cast<int>(std::lround(q.y() * (1 << kFractionBits))));
    }
    return out;
  }

  void solid(const std::vector<Pixel>& points, const Stroke& stroke) {
    if (points.empty()) return;
    cv::polylines(window, fixed_point(points), false, bgr(stroke.color), thickness(stroke.width),
                  cv::LINE_AA, kFractionBits);
  }
};

Canvas::Canvas(int width, int height) : sheet_(std::make_unique<Sheet>()) {
  sheet_->all = cv::Mat(height * kScale, width * kScale, CV_8UC3, cv::Scalar(255, 255, 255));
  sheet_->window = sheet_->all;
}

Canvas::~Canvas() = default;

void Canvas::paste(const Image& doubled, const Pixel& corner) {
  const cv::Mat rgb(doubled.height, doubled.width, CV_8UC3,
                    const_cast<std::uint8_t*>(doubled.rgb.data()));
  const cv::Rect whole(static_cast<int>(corner.x() * kScale), static_cast<int>(corner.y() * kScale),
                       doubled.width, doubled.height);
  const cv::Rect seen = whole & cv::Rect(0, 0, sheet_->all.cols, sheet_->all.rows);
  if (seen.empty()) return;
  cv::cvtColor(rgb(seen - whole.tl()), sheet_->all(seen), cv::COLOR_RGB2BGR);
}

void Canvas::clip(const Box& box) {
  const cv::Rect all(0, 0, sheet_->all.cols, sheet_->all.rows);
  const cv::Point first(static_cast<int>(box.left * kScale), static_cast<int>(box.top * kScale));
  const cv::Point last(static_cast<int>(box.right * kScale), static_cast<int>(box.bottom * kScale));
  const cv::Rect part = cv::Rect(first, last) & all;
  sheet_->window = sheet_->all(part);
  sheet_->origin = Pixel(part.x, part.y);
}

void Canvas::unclip() {
  sheet_->window = sheet_->all;
  sheet_->origin.setZero();
}

void Canvas::line(const Pixel& a, const Pixel& b, const Stroke& stroke) {
  polyline({a, b}, stroke);
}

void Canvas::polyline(const std::vector<Pixel>& points, const Stroke& stroke) {
  if (stroke.style == LineStyle::kNone) return;
  const bool dashed = stroke.style == LineStyle::kDashed;
  const double on = stroke.style == LineStyle::kSolid ? 1e300 : stroke.width * (dashed ? 4.5 : 0.1);
  const double off = stroke.width * (dashed ? 3 : 2.2);
  std::vector<Pixel> piece;
  bool drawing = true;
  double left = on;  // pixels until the pen is lifted or lowered
  const auto finish = [&] {
    sheet_->solid(piece, stroke);
    piece.clear();
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].allFinite()) {
      finish();
      continue;
    }
    if (i == 0 || !points[i - 1].allFinite()) {
      piece = {points[i]};
      drawing = true;
      left = on;
      continue;
    }
    Pixel at = points[i - 1];
    const double length = std::min((points[i] - at).norm(), kFarAway);
    const Pixel direction = length > 0 ? Pixel((points[i] - at) / length) : Pixel::Zero();
    double rest = length;
    while (rest > left) {
      at += left * direction;
      rest -= left;
      if (drawing) piece.push_back(at);
      if (drawing) finish();
      drawing = !drawing;
      left = drawing ? on : off;
      if (drawing) piece = {at};
    }
    left -= rest;
    if (drawing) piece.push_back(points[i]);
  }
  finish();
}

void Canvas::fill(const std::vector<Pixel>& corners, Color color, double opacity) {
  for (const Pixel& p : corners) {
    if (!p.allFinite()) return;
  }
  const std::vector<cv::Point> points = sheet_->fixed_point(corners);
  if (points.empty()) return;
  if (opacity >= 1) {
    cv::fillPoly(sheet_->window, std::vector<std::vector<cv::Point>>{points}, bgr(color),
                 cv::LINE_AA, kFractionBits);
    return;
  }
  cv::Rect bounds = cv::boundingRect(points);
  bounds =
      cv::Rect(bounds.x / (1 << kFractionBits) - 2, bounds.y / (1 << kFractionBits) - 2,
               bounds.width / (1 << kFractionBits) + 5, bounds.height / (1 << kFractionBits) + 5) &
      cv::Rect(0, 0, sheet_->window.cols, sheet_->window.rows);
  if (bounds.empty()) return;
  cv::Mat mask = cv::Mat::zeros(bounds.size(), CV_8UC1);
  std::vector<cv::Point> local = points;
  for (cv::Point& p : local) p -= cv::Point(bounds.x, bounds.y) * (1 << kFractionBits);
  cv::fillPoly(mask, std::vector<std::vector<cv::Point>>{local}, cv::Scalar(255 * opacity),
               cv::LINE_AA, kFractionBits);
  blend(sheet_->window(bounds), mask, color);
}

void Canvas::rectangle(const Box& b, const Stroke& stroke) {
  polyline(
      {{b.left, b.top}, {b.right, b.top}, {b.right, b.bottom}, {b.left, b.bottom}, {b.left, b.top}},
      stroke);
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
  int below = 0;
  const cv::Size size =
      cv::getTextSize(text, kFont, font_scale(style), font_thickness(style), &below);
  const Eigen::Vector2d extent(static_cast<double>(size.width) / kScale, style.size);
  return style.upwards ? Eigen::Vector2d(extent.y(), extent.x()) : extent;
}

void Canvas::text(const Pixel& at, const std::string& text, const TextStyle& style) {
  if (text.empty() || !at.allFinite()) return;
  const int pen = font_thickness(style);
  const int rim = style.halo ? thickness(0.22 * style.size) : 0;
  int below = 0;
  const cv::Size size = cv::getTextSize(text, kFont, font_scale(style), pen, &below);
  const int margin = pen + rim + 2;
  const int descent = size.height / 2;  // room for descenders and brackets
  const int cap = static_cast<int>(std::lround(style.size * kScale));
  cv::Mat mask = cv::Mat::zeros(cap + descent + 2 * margin, size.width + 2 * margin, CV_8UC1);
  const cv::Point base(margin, margin + cap);
  cv::putText(mask, text, base, kFont, font_scale(style), 255, pen, cv::LINE_AA);
  cv::Mat halo = cv::Mat::zeros(mask.size(), CV_8UC1);
  if (style.halo) {
    cv::putText(halo, text, base, kFont, font_scale(style), 255, pen + 2 * rim, cv::LINE_AA);
  }
  const Eigen::Vector2d extent = text_extent(text, style) * kScale;
  Pixel corner = at * kScale - sheet_->origin +
                 Pixel(shift(style.horizontal, extent.x()), shift(style.vertical, extent.y()));
  corner -= Pixel(margin, margin);
  if (style.upwards) {
    cv::rotate(mask, mask, cv::ROTATE_90_COUNTERCLOCKWISE);
    cv::rotate(halo, halo, cv::ROTATE_90_COUNTERCLOCKWISE);
  }
  const cv::Rect whole(static_cast<int>(std::lround(corner.x())),
                       static_cast<int>(std::lround(corner.y())), mask.cols, mask.rows);
  const cv::Rect seen = whole & cv::Rect(0, 0, sheet_->window.cols, sheet_->window.rows);
  if (seen.empty()) return;
  const cv::Rect part(seen.x - whole.x, seen.y - whole.y, seen.width, seen.height);
  if (style.halo) blend(sheet_->window(seen), halo(part), palette::kWhite);
  blend(sheet_->window(seen), mask(part), style.color);
}

Image Canvas::image() const {
  cv::Mat reduced;
  cv::resize(sheet_->all, reduced, cv::Size(sheet_->all.cols / kScale, sheet_->all.rows / kScale),
             0, 0, cv::INTER_AREA);
  cv::cvtColor(reduced, reduced, cv::COLOR_BGR2RGB);
  Image image;
  image.width = reduced.cols;
  image.height = reduced.rows;
  image.rgb.assign(reduced.datastart, reduced.dataend);
  return image;
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
