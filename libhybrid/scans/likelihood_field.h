// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "libhybrid/geometry/eigen.h"

namespace HYBRID_API hybrid {

/// The likelihood of a return by place, as a grid, and its maxima over squares of 2, 4, 8, ...
/// cells (Olson 2009; Hess et al. 2016).
class LikelihoodField {
 public:
  LikelihoodField() = default;
  /// The likelihood falls with the distance to the nearest of the `points` as a Gaussian of `sigma`
  /// [m]; it is zero outside. Points farther than 60 m from the first are left out.
  LikelihoodField(const std::vector<Eigen::Vector2d>& points, double resolution, double sigma);

  double resolution() const { return resolution_; }
  int levels() const { return static_cast<int>(levels_.size()); }
  bool empty() const { return levels_.empty(); }
  /// The cell of a place.
  Eigen::Vector2i cell(const Eigen::Vector2d& position) const;
  /// The largest likelihood, times 255, of the cells from (x, y) to (x + 2^level - 1, y + 2^level -
  /// 1).
  int at(int level, int x, int y) const {
    const unsigned column = static_cast<unsigned>(x + margin_);
    const unsigned row = static_cast<unsigned>(y + margin_);
    if (column >= static_cast<unsigned>(columns_) || row >= static_cast<unsigned>(rows_)) return 0;
    return levels_[level][row * static_cast<std::size_t>(columns_) + column];
  }

 private:
  void draw(const Eigen::Vector2d& point, double sigma);
  void make_levels();

  double resolution_ = 0.1;
  Eigen::Vector2d corner_ = Eigen::Vector2d::Zero();
  int margin_ = 0;  // cells below (0, 0), so that squares that begin outside are in the grid
  int columns_ = 0, rows_ = 0;
  std::vector<std::vector<std::uint8_t>> levels_;
};

}  // namespace hybrid
