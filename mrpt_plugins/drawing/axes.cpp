// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/drawing/axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace hybrid {
namespace {

constexpr double kTextSize = 15;

/// Position of a value along an axis, 0 at the low end and 1 at the high end.
double fraction(const Axis& axis, double value) {
  const auto [low, high] = *axis.range;
  if (axis.scale == Scale::kLog) return std::log(value / low) / std::log(high / low);
  return (value - low) / (high - low);
}

}  // namespace

double nice_below(double value) {
  const double power = std::pow(10.0, std::floor(std::log10(value)));
  const double digit = value / power;
  return power * (digit >= 5 ? 5 : digit >= 2 ? 2 : 1);
}

std::vector<double> nice_ticks(double low, double high, int count) {
  std::vector<double> out;
  if (!(high > low) || count < 1) return out;
  const double wanted = (high - low) / count;
  double step = nice_below(wanted);
  if (step < wanted * (1 - 1e-9)) step = nice_below(step * 2.6);
  const auto first = static_cast<long>(std::ceil(low / step - 1e-9));
  const auto last = static_cast<long>(std::floor(high / step + 1e-9));
  for (long i = first; i <= last; ++i) out.push_back(static_cast<double>(i) * step);
  return out;
}

std::string tick_text(double value, double step) {
  const double size = std::max(std::abs(value), step);
  if (size >= 1e6 || (step < 1e-4 && step > 0)) return fmt::format("{:.3g}", value);
  const int digits = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  return fmt::format("{:.{}f}", value, digits);
}

Axes::Axes(const Box& box, const Axis& x, const Axis& y, bool y_down)
    : box_(box), x_(x), y_(y), y_down_(y_down) {}

Pixel Axes::pixel(double x, double y) const {
  const double up = fraction(y_, y);
  return {box_.left + fraction(x_, x) * box_.width(),
          y_down_ ? box_.top + up * box_.height() : box_.bottom - up * box_.height()};
}

double Axes::pixels_per_unit() const {
  return box_.width() / (x_.range->second - x_.range->first);
}

std::vector<Axes::Tick> Axes::ticks(const Axis& axis, double pixels, double spacing) {
  const auto [low, high] = *axis.range;
  std::vector<Tick> out;
  const int count = std::max(2, static_cast<int>(pixels / spacing));
  if (axis.scale == Scale::kLinear) {
    const std::vector<double> values = nice_ticks(low, high, count);
    const double step = values.size() > 1 ? values[1] - values[0] : high - low;
    for (const double v : values) out.push_back({v, tick_text(v, step)});
    return out;
  }
  const int first = static_cast<int>(std::floor(std::log10(low) + 1e-9));
  const int last = static_cast<int>(std::ceil(std::log10(high) - 1e-9));
  const int every = std::max(1, (last - first + count - 1) / count);
  const double decades = std::log10(high / low);
  for (int p = first; p <= last; ++p) {
    for (int digit = 1; digit < 10; ++digit) {
      const double v = digit * std::pow(10.0, p);
      if (v < low * (1 - 1e-9) || v > high * (1 + 1e-9)) continue;
      const bool major =
          digit == 1 ? (p - first) % every == 0 : decades < 2.2 && (digit == 2 || digit == 5);
      if (!major && every > 1) continue;
      out.push_back({v, major ? fmt::format("{:g}", v) : ""});
    }
  }
  return out;
}

double Axes::left_room() const {
  TextStyle style;
  style.size = kTextSize;
  double widest = 0;
  for (const Tick& t : ticks(y_, box_.height(), 70)) {
    widest = std::max(widest, Canvas::text_extent(t.text, style).x());
  }
  return widest + (y_.label.empty() ? 30 : 70);
}

void Axes::draw(Canvas& canvas) const {
  const Stroke grid{palette::kFaint, 1};
  const Stroke minor{{242, 242, 242}, 1};
  TextStyle style;
  style.size = kTextSize;
  style.horizontal = Align::kCenter;
  style.vertical = Align::kStart;
  for (const Tick& t : ticks(x_, box_.width(), 110)) {
    const double x = box_.left + fraction(x_, t.value) * box_.width();
    canvas.line({x, box_.top}, {x, box_.bottom}, t.text.empty() ? minor : grid);
    canvas.line({x, box_.bottom}, {x, box_.bottom + 6}, {palette::kInk, 1});
    canvas.text({x, box_.bottom + 13}, t.text, style);
  }
  style.horizontal = Align::kEnd;
  style.vertical = Align::kCenter;
  for (const Tick& t : ticks(y_, box_.height(), 70)) {
    const double y = pixel(x_.range->first, t.value).y();
    canvas.line({box_.left, y}, {box_.right, y}, t.text.empty() ? minor : grid);
    canvas.line({box_.left - 6, y}, {box_.left, y}, {palette::kInk, 1});
    canvas.text({box_.left - 12, y}, t.text, style);
  }
  canvas.rectangle(box_, {palette::kInk, 1.25});
  style.size = kTextSize + 1;
  style.horizontal = Align::kCenter;
  style.vertical = Align::kStart;
  canvas.text({0.5 * (box_.left + box_.right), box_.bottom + 46}, x_.label, style);
  style.upwards = true;
  style.horizontal = Align::kStart;
  style.vertical = Align::kCenter;
  canvas.text({box_.left - left_room() + 18, 0.5 * (box_.top + box_.bottom)}, y_.label, style);
}

void Axes::equalize(const Box& box, Axis& x, Axis& y) {
  const double unit = std::max((x.range->second - x.range->first) / box.width(),
                               (y.range->second - y.range->first) / box.height());
  const auto widen = [unit](Axis& axis, double pixels) {
    const double middle = 0.5 * (axis.range->first + axis.range->second);
    axis.range = {{middle - 0.5 * unit * pixels, middle + 0.5 * unit * pixels}};
  };
  widen(x, box.width());
  widen(y, box.height());
}

}  // namespace hybrid
