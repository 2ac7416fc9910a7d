// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/likelihood_field.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace hybrid {
namespace {

constexpr int kLevels = 5;
constexpr double kMaxReach = 60.0;
/// Standard deviations around a point that are drawn.
constexpr double kDrawn = 2.5;

}  // namespace

LikelihoodField::LikelihoodField(const std::vector<Eigen::Vector2d>& points, double resolution,
                                 double sigma)
    : resolution_(resolution), margin_(1 << (kLevels - 1)) {
  if (points.empty()) return;
  const auto is_used = [&](const Eigen::Vector2d& p) {
    return (p - points.front()).cwiseAbs().maxCoeff() < kMaxReach;
  };
  Eigen::Array2d low = points.front().array();
  Eigen::Array2d high = low;
  for (const Eigen::Vector2d& p : points) {
    if (!is_used(p)) continue;
    low = low.min(p.array());
    high = high.max(p.array());
  }
  const double border = kDrawn * sigma + resolution;
  corner_ = low.matrix() - Eigen::Vector2d::Constant(border);
  const Eigen::Vector2i last = cell(high.matrix() + Eigen::Vector2d::Constant(border));
  columns_ = last.x() + 1 + margin_;
  rows_ = last.y() + 1 + margin_;
  levels_.emplace_back(static_cast<std::size_t>(columns_) * rows_, std::uint8_t{0});
  for (const Eigen::Vector2d& p : points) {
    if (is_used(p)) draw(p, sigma);
  }
  make_levels();
}

Eigen::Vector2i LikelihoodField::cell(const Eigen::Vector2d& position) const {
  const Eigen::Vector2d at = (position - corner_) / resolution_;
  return {static_cast<int>(std::floor(at.x())), static_cast<int>(std::floor(at.y()))};
}

void LikelihoodField::draw(const Eigen::Vector2d& point, double sigma) {
  const Eigen::Vector2i centre = cell(point);
  const int reach = static_cast<int>(std::ceil(kDrawn * sigma / resolution_));
  for (int y = centre.y() - reach; y <= centre.y() + reach; ++y) {
    for (int x = centre.x() - reach; x <= centre.x() + reach; ++x) {
      if (x < 0 || y < 0 || x + margin_ >= columns_ || y + margin_ >= rows_) continue;
      const Eigen::Vector2d middle = corner_ + resolution_ * Eigen::Vector2d(x + 0.5, y + 0.5);
      const double s = (middle - point).squaredNorm() / (2.0 * sigma * sigma);
      const auto value = static_cast<std::uint8_t>(std::lround(255.0 * std::exp(-s)));
      std::uint8_t& place =
          levels_[0][static_cast<std::size_t>(y + margin_) * columns_ + (x + margin_)];
      place = std::max(place, value);
    }
  }
}

void LikelihoodField::make_levels() {
  for (int level = 1; level < kLevels; ++level) {
    const std::vector<std::uint8_t>& finer = levels_.back();
    const int shift = 1 << (level - 1);
    std::vector<std::uint8_t> wide = finer;  // maxima along rows
    for (int y = 0; y < rows_; ++y) {
      const std::uint8_t* from = finer.data() + static_cast<std::size_t>(y) * columns_;
      std::uint8_t* to = wide.data() + static_cast<std::size_t>(y) * columns_;
      for (int x = 0; x + shift < columns_; ++x) to[x] = std::max(from[x], from[x + shift]);
    }
    std::vector<std::uint8_t> both = wide;
    for (int y = 0; y + shift < rows_; ++y) {
      const std::uint8_t* from = wide.data() + static_cast<std::size_t>(y) * columns_;
      const std::uint8_t* next = from + static_cast<std::size_t>(shift) * columns_;
      std::uint8_t* to = both.data() + static_cast<std::size_t>(y) * columns_;
      for (int x = 0; x < columns_; ++x) to[x] = std::max(from[x], next[x]);
    }
    levels_.push_back(std::move(both));
  }
}

}  // namespace hybrid
