// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/spatial_grid.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <utility>
#include <vector>

namespace hybrid {
namespace {

TEST(SpatialGrid, FindsEveryPointInTheSquareOnce) {
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> at(-100, 100);
  SpatialGrid grid(7.0);
  std::vector<std::pair<double, double>> points(500);
  for (int round = 0; round < 2; ++round) {  // the second moves all of them
    for (int i = 0; i < 500; ++i) {
      points[i] = {at(engine), at(engine)};
      grid.put(i, points[i].first, points[i].second);
    }
  }
  for (int i = 0; i < 500; i += 10) grid.remove(i);
  for (double radius : {0.5, 10.0, 50.0, 1e6}) {
    std::multiset<int> found;
    grid.visit_near(10, -20, radius, [&](int id) { found.insert(id); });
    for (int i = 0; i < 500; ++i) {
      const bool inside = i % 10 != 0 && std::abs(points[i].first - 10) <= radius &&
                          std::abs(points[i].second + 20) <= radius;
      if (inside) {
        EXPECT_EQ(found.count(i), 1u) << i;
      } else {
        EXPECT_LE(found.count(i), 1u) << i;
      }
      if (i % 10 == 0) {
        EXPECT_EQ(found.count(i), 0u);
      }
    }
  }
}

TEST(SpatialGrid, TheOrderDependsOnWherePointsAreAlone) {
  SpatialGrid grid, moved;
  for (const int id : {4, 0, 2, 7}) grid.put(id, 1, 1);
  for (const int id : {2, 7, 4, 0}) moved.put(id, id % 4 == 0 ? 1 : 100, 1);
  moved.put(7, 1, 1);
  moved.put(2, 1, 1);
  const auto order = [](const SpatialGrid& of) {
    std::vector<int> ids;
    of.visit_near(0, 0, 1, [&](int id) { ids.push_back(id); });
    return ids;
  };
  for (int id = 10; id < 40; ++id) {  // so that cells are looked up, not all points
    grid.put(id, 10 * id, 300);
    moved.put(id, 10 * id, 300);
  }
  EXPECT_EQ(order(grid), order(moved));
}

TEST(SpatialGrid, RemovingWhatIsNotThereChangesNothing) {
  SpatialGrid grid;
  grid.remove(3);
  grid.put(1, 0, 0);
  grid.remove(0);
  int count = 0;
  grid.visit_near(0, 0, 1, [&](int) { ++count; });
  EXPECT_EQ(count, 1);
}

}  // namespace
}  // namespace hybrid
