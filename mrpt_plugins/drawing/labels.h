// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "mrpt_plugins/drawing/canvas.h"

namespace HYBRID_API hybrid {

/// Puts texts beside points so that none covers another, a marker, or more of the lines than it has
/// to; a text without a free place is left out.
class LabelPlacer {
 public:
  /// Texts stay inside `area`.
  explicit LabelPlacer(const Box& area);

  /// Keeps texts away from a marker.
  void block(const Pixel& center, double radius);
  /// Makes places on a line less welcome.
  void avoid(const std::vector<Pixel>& line);

  /// Draws `text` near `point`, which carries a marker of the given radius; false if left out.
  bool place(Canvas& canvas, const Pixel& point, double radius, const std::string& text,
             const TextStyle& style);

 private:
  using Grid = std::vector<std::uint8_t>;  // a cell is 1 where something is

  Box cells(const Box& box) const;
  int taken(const Grid& grid, const Box& cells) const;
  void take(Grid& grid, const Box& cells);

  Box area_;
  int columns_, rows_;
  Grid blocked_, lines_;
};

}  // namespace hybrid
