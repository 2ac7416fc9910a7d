// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/likelihood_field.h"

#include <gtest/gtest.h>

#include <random>

namespace hybrid {
namespace {

TEST(LikelihoodField, LevelsAreMaximaOverSquares) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> place(-2.0, 2.0);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 30; ++i) points.emplace_back(place(random), place(random));
  const LikelihoodField field(points, 0.1, 0.12);
  ASSERT_GT(field.levels(), 2);
  for (int level = 1; level < field.levels(); ++level) {
    const int size = 1 << level;
    for (int y = -20; y < 60; y += 3) {
      for (int x = -20; x < 60; x += 3) {
        int most = 0;
        for (int v = y; v < y + size; ++v) {
          for (int u = x; u < x + size; ++u) most = std::max(most, field.at(0, u, v));
        }
        // Squares that begin before the margin count as empty.
        if (x >= -16 && y >= -16) {
          EXPECT_EQ(field.at(level, x, y), most) << level << x << y;
        }
      }
    }
  }
}

TEST(LikelihoodField, PeaksAtPoints) {
  const LikelihoodField field({{1.03, -0.58}}, 0.1, 0.12);
  const Eigen::Vector2i cell = field.cell({1.03, -0.58});
  EXPECT_GT(field.at(0, cell.x(), cell.y()), 200);
  EXPECT_LT(field.at(0, cell.x() + 2, cell.y()), 100);
  EXPECT_EQ(field.at(0, cell.x() + 50, cell.y()), 0);
  EXPECT_TRUE(LikelihoodField({}, 0.1, 0.1).empty());
}

}  // namespace
}  // namespace hybrid
