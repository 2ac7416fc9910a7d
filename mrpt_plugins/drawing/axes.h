// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mrpt_plugins/drawing/canvas.h"

namespace HYBRID_API hybrid {

enum class Scale { kLinear, kLog };

/// One axis of a plot. Without a range it fits the data.
struct Axis {
  std::string label;
  Scale scale = Scale::kLinear;
  std::optional<std::pair<double, double>> range = std::nullopt;
};

/// Round numbers (1, 2 or 5 times a power of ten) inside [low, high], about `count` of them.
std::vector<double> nice_ticks(double low, double high, int count);

/// The largest 1, 2 or 5 times a power of ten not above `value` > 0.
double nice_below(double value);

/// A short text for a tick, with the digits that ticks `step` apart need.
std::string tick_text(double value, double step);

/// The frame of a plot: data coordinates in, pixels out.
class Axes {
 public:
  /// Both ranges must be increasing (and positive on a logarithmic axis); `y_down` puts the low end
  /// of y at the top.
  Axes(const Box& box, const Axis& x, const Axis& y, bool y_down = false);

  Pixel pixel(double x, double y) const;
  const Box& box() const { return box_; }
  double pixels_per_unit() const;  ///< along x, linear axes only

  /// Grid, frame, ticks with numbers and axis labels, around and inside the box.
  void draw(Canvas& canvas) const;

  /// Pixels needed on the left of the box for the numbers and the label of the y axis.
  double left_room() const;

  /// Ranges that show `box` with the same scale in x and y, centred on the given ranges.
  static void equalize(const Box& box, Axis& x, Axis& y);

 private:
  struct Tick {
    double value;
    std::string text;  // empty for a minor tick
  };
  static std::vector<Tick> ticks(const Axis& axis, double pixels, double spacing);

  Box box_;
  Axis x_, y_;
  bool y_down_;
};

}  // namespace hybrid
