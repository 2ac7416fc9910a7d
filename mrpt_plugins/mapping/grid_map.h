// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <cstdint>
#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// A plan of what laser scans saw, seen from above: square cells, row by row from the lowest y, x
/// to the right.
struct GridMap {
  enum Cell : std::uint8_t { kUnknown, kFree, kOccupied };

  double resolution = 0.05;                          ///< size of a cell [m]
  Eigen::Vector2d corner = Eigen::Vector2d::Zero();  ///< lowest x and y, in the frame of the map
  int width = 0, height = 0;                         ///< cells
  std::vector<Cell> cells;

  bool empty() const { return cells.empty(); }
  Cell at(int x, int y) const {
    return cells[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                 static_cast<std::size_t>(x)];
  }
};

}  // namespace hybrid
