// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/geometry/thin_points.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace hybrid {
namespace {

Points spiral(int count) {
  Points points;
  for (int i = 0; i < count; ++i) {
    points.emplace_back(0.01 * i * std::cos(i), 0.01 * i * std::sin(i), 0.001 * (i % 7));
  }
  return points;
}

TEST(ThinPoints, KeepsTheFirstOfEachVoxelInTheirOrder) {
  const Points points = spiral(5000);
  for (const std::size_t most : {1U, 7U, 100U, 1000U, 4999U}) {
    const std::vector<std::size_t> kept = thin_points(points, most);
    EXPECT_LE(kept.size(), most);
    EXPECT_GE(kept.size(), most / 2) << "voxels no larger than needed";
    EXPECT_EQ(kept.front(), 0U);
    EXPECT_LT(kept.back(), points.size());
    EXPECT_EQ(kept, thin_points(points, most));
    EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
  }
}

TEST(ThinPoints, KeepsAllWhereTheyAreNoMore) {
  const Points points = spiral(50);
  const std::vector<std::size_t> all = thin_points(points, 50);
  for (std::size_t i = 0; i < 50; ++i) EXPECT_EQ(all.at(i), i);
  EXPECT_TRUE(thin_points({}, 10).empty());
  EXPECT_TRUE(thin_points(points, 0).empty());
}

// Coordinates as large as files may have them, and points in one place.
TEST(ThinPoints, ExtremesEnd) {
  EXPECT_EQ(thin_points({{1e15, 0, 0}, {-1e15, 0, 0}, {0, 0, 0}}, 1).size(), 1U);
  EXPECT_EQ(thin_points({{1e15, 0, 0}, {-1e15, 0, 0}, {0, 0, 0}}, 2).size(), 2U);
  EXPECT_EQ(thin_points(Points(100, {1, 2, 3}), 10).size(), 1U);
}

}  // namespace
}  // namespace hybrid
