// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/io/detail/dump.h"

#include <gtest/gtest.h>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"

namespace hybrid {
namespace {

TEST(Dump, HasOneLinePerFactorAndVariable) {
  const Key a{'x', 0}, b{'x', 1};
  HybridGraph graph;
  graph.emplace<Prior<SE2>>(a, SE2(), Noise::unit(3));
  graph.add(Table({{Key('d', 0), 2}}, {0.5, 1.5}));
  graph.add(make_outlier_mixture({Key('d', 0), 2},
                                 std::make_shared<BetweenSE2>(a, b, SE2(), Noise::unit(3)), nullptr,
                                 1, 0.5));
  EXPECT_EQ(dump(graph),
            "c#0.1 prior x0\n"
            "d#0.1 table d0:2\n"
            "h#0.1 mixture x0 x1 | d0:2\n");
  Estimate estimate;
  estimate.values.insert(b, SE2(1.0, 2.0, 0.5));
  estimate.values.insert(a, SE2(2.0, 0.0, 0.0));
  estimate.assignment.set(Key('d', 0), 1);
  EXPECT_EQ(dump(graph, &estimate),
            "c#0.1 prior x0 cost 2\n"
            "d#0.1 table d0:2 cost 1.5\n"
            "h#0.1 mixture x0 x1 | d0:2 component 1 cost 0.693147\n");
  EXPECT_EQ(dump(estimate),
            "x0 SE2: 2 0 0\n"
            "x1 SE2: 1 2 0.5\n"
            "d0 = 1\n");
}

}  // namespace
}  // namespace hybrid
