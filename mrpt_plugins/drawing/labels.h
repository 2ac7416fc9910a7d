// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mrpt_plugins/drawing/canvas.h"

namespace HYBRID_API hybrid {

/// Places texts beside points so that no text covers another one or a marker, and each covers as
/// little of the lines as possible. A text without a free place is left out.
class LabelPlacer {
 public:
  /// Texts stay inside `area`.
  explicit LabelPlacer(const Box& area);

  /// Keeps texts away from a marker.
  void block(const Pixel& center, double radius);
  /// Makes places on a line less preferred.
  void avoid(const std::vector<Pixel>& line);

  /// Draws `text` near `point`, which carries a marker of the given radius; false if left out.
  bool place(Canvas& canvas, const Pixel& point, double radius, const std::string& text,
             const TextStyle& style);

 private:
  using Grid = std::vector<std::uint8_t>;  // 1 for an occupied cell

  Box cells(const Box& box) const;
  int taken(const Grid& grid, const Box& cells) const;
  void take(Grid& grid, const Box& cells);

  Box area_;
  int columns_, rows_;
  Grid blocked_, lines_;
};

}  // namespace hybrid
