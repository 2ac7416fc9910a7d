// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/scans/surface_map.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hybrid {
namespace {

TEST(SurfaceMap, FindsTheNearestOfTheRightDirection) {
  const SurfaceMap map({{{1.0, 0.0}, {-1, 0}, 0.1}, {{1.3, 0.0}, {1, 0}, 0.1}});
  ASSERT_EQ(map.surfels().size(), 2u);
  EXPECT_EQ(map.nearest({1.2, 0.0}, {-1, 0}, 0.4)->position.x(), 1.0);
  EXPECT_EQ(map.nearest({1.1, 0.0}, {1, 0}, 0.4)->position.x(), 1.3);
  EXPECT_EQ(map.nearest({1.2, 0.0}, {0, 0}, 0.4)->position.x(), 1.3);
  EXPECT_EQ(map.nearest({1.2, 0.0}, {0, 1}, 0.4), nullptr);
  EXPECT_EQ(map.nearest({2.0, 0.0}, {-1, 0}, 0.4), nullptr);
  EXPECT_EQ(map.nearest({1e9, -1e9}, {-1, 0}, 0.4), nullptr);
}

TEST(SurfaceMap, IsTheSameAsAnExhaustiveSearch) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-3.0, 3.0);
  std::vector<SurfacePoint> points;
  for (int i = 0; i < 300; ++i) points.push_back({{place(random), place(random)}, {0, 1}, 0.1});
  const SurfaceMap map(points, 0.0);
  ASSERT_EQ(map.surfels().size(), points.size());
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector2d at(place(random), place(random));
    double least = 0.4;
    for (const SurfacePoint& point : points) least = std::min(least, (point.position - at).norm());
    const auto* found = map.nearest(at, {0, 1}, 0.4);
    ASSERT_EQ(found != nullptr, least < 0.4);
    if (found != nullptr) {
      EXPECT_DOUBLE_EQ((found->position - at).norm(), least);
    }
  }
}

TEST(SurfaceMap, JoinsPointsOfOneSurface) {
  const SurfaceMap map({{{0.83, -0.17}, {1, 0}, 0.1},
                        {{1.00, 0.01}, {0, 1}, 0.1},
                        {{1.02, 0.03}, {0, 1}, 0.1},
                        {{1.01, 0.02}, {0, -1}, 0.1}});
  EXPECT_EQ(map.surfels().size(), 3u);
  const SurfaceMap::Surfel* joined = map.nearest({1.01, 0.02}, {0, 1}, 0.1);
  ASSERT_NE(joined, nullptr);
  EXPECT_NEAR(joined->position.y(), 0.02, 1e-12);
  EXPECT_EQ(joined->count, 2.0);
}

TEST(SurfaceMap, MayBeEmpty) {
  EXPECT_EQ(SurfaceMap().nearest({0, 0}, {1, 0}, 0.4), nullptr);
  EXPECT_TRUE(SurfaceMap({{{1e12, 0.0}, {1, 0}, 0.1}}).empty());
}

}  // namespace
}  // namespace hybrid
