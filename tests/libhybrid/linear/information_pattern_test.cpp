// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/linear/information_pattern.h"

#include <gtest/gtest.h>

#include <memory>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"

namespace hybrid {
namespace {

TEST(InformationPattern, FollowsTheAssignment) {
  const Key x0{'x', 0}, x1{'x', 1}, x2{'x', 2}, d{'d', 0};
  const Noise noise = Noise::isotropic(3, 0.1);
  HybridGraph graph;
  graph.emplace<Prior<SE2>>(x0, SE2(), noise);
  graph.emplace<BetweenSE2>(x1, x0, SE2(), noise);
  graph.emplace<BetweenSE2>(x1, x2, SE2(), noise);
  const auto closure = std::make_shared<BetweenSE2>(x0, x2, SE2(), noise);
  const auto wide = std::make_shared<BetweenSE2>(x0, x2, SE2(), Noise::isotropic(3, 300.0));
  graph.add(make_outlier_mixture({d, 2}, closure, wide, 0.5, 0.5));
  using Edges = std::vector<std::pair<int, int>>;
  Edges with, without;
  for (int value : {0, 1}) {
    Assignment assignment;
    assignment.set(d, value);
    const BlockPattern pattern = information_pattern(graph, assignment);
    EXPECT_EQ(pattern.dims, (std::vector<int>{3, 3, 3}));
    (pattern.edges.size() == 3 ? with : without) = pattern.edges;
  }
  EXPECT_EQ(with, (Edges{{0, 1}, {0, 2}, {1, 2}}));
  EXPECT_EQ(without, (Edges{{0, 1}, {1, 2}}));  // the component of outliers couples nothing
}

}  // namespace
}  // namespace hybrid
