// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// The place of a cube in a grid of space.
struct GridCell {
  std::int32_t x = 0, y = 0, z = 0;

  bool operator==(const GridCell& o) const { return x == o.x && y == o.y && z == o.z; }
  GridCell operator+(const GridCell& o) const { return {x + o.x, y + o.y, z + o.z}; }
};

/// For tables of cells.
struct GridCellHash {
  std::size_t operator()(const GridCell& c) const {
    std::uint64_t h = static_cast<std::uint32_t>(c.x);
    h = h * 0x9E3779B97F4A7C15ULL + static_cast<std::uint32_t>(c.y);
    h = h * 0x9E3779B97F4A7C15ULL + static_cast<std::uint32_t>(c.z);
    return h ^ (h >> 29);
  }
};

/// The cell of a point; one at the rim of the grid where that is farther than 10^9 edges.
inline GridCell grid_cell(const Eigen::Vector3d& p, double edge) {
  const auto at = [edge](double v) {
    return static_cast<std::int32_t>(std::floor(std::clamp(v / edge, -1e9, 1e9)));
  };
  return {at(p.x()), at(p.y()), at(p.z())};
}

/// Steps from a cell to itself and the 26 around.
inline const std::array<GridCell, 27>& cells_around() {
  static const std::array<GridCell, 27> kSteps = [] {
    std::array<GridCell, 27> out;
    for (int i = 0; i < 27; ++i)
      out[static_cast<std::size_t>(i)] = {i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
    return out;
  }();
  return kSteps;
}

}  // namespace hybrid
