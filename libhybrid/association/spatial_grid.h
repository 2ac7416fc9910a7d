// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// Points by number in square cells of the x-y plane, to find those near a place at a cost that
/// depends on how many there are near it, not on how many there are.
class SpatialGrid {
 public:
  /// `cell` is the side of a cell [m], positive.
  explicit SpatialGrid(double cell = 5.0) : cell_(cell) {}

  /// Adds point `id`, a number from 0, or moves it. Coordinates beyond x and y do not count.
  void put(int id, double x, double y);
  void remove(int id);
  /// The middle of the cell of a point.
  std::array<double, 2> middle(int id) const {
    const Place& place = place_[id];
    return {cell_ * (static_cast<double>(place.x) + 0.5),
            cell_ * (static_cast<double>(place.y) + 0.5)};
  }

  /// Calls visit(id) for every point whose cell is touched by the square of half side `radius`
  /// around (x, y), in an order that depends on where points are, not on how they came there.
  template <class Visit>
  void visit_near(double x, double y, double radius, Visit&& visit) const {
    const std::int64_t x0 = index(x - radius), x1 = index(x + radius);
    const std::int64_t y0 = index(y - radius), y1 = index(y + radius);
    const double cells = (static_cast<double>(x1 - x0) + 1) * (static_cast<double>(y1 - y0) + 1);
    if (cells > static_cast<double>(cells_.size())) {  // all of them are fewer
      for (int id = 0; id < static_cast<int>(place_.size()); ++id) {
        const Place& p = place_[id];
        if (p.used && p.x >= x0 && p.x <= x1 && p.y >= y0 && p.y <= y1) visit(id);
      }
      return;
    }
    for (std::int64_t i = x0; i <= x1; ++i) {
      for (std::int64_t j = y0; j <= y1; ++j) {
        const auto it = cells_.find(name(i, j));
        if (it == cells_.end()) continue;
        for (int id : it->second) {
          if (place_[id].x == i && place_[id].y == j) visit(id);
        }
      }
    }
  }

 private:
  struct Place {
    std::int64_t x = 0, y = 0;
    bool used = false;
  };

  std::int64_t index(double v) const { return static_cast<std::int64_t>(std::floor(v / cell_)); }
  static std::uint64_t name(std::int64_t i, std::int64_t j) {
    return (static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15ULL) ^ static_cast<std::uint64_t>(j);
  }

  double cell_;
  std::vector<Place> place_;  // by id
  std::unordered_map<std::uint64_t, std::vector<int>> cells_;
};

}  // namespace hybrid
