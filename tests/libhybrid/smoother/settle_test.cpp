// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <string>

#include "libhybrid/smoother/incremental.h"
#include "tests/support/changing_world.h"

namespace hybrid {
namespace {

using testing::between;
using testing::pose;

/// A map whose last update has left much undone: a closure that is off by much, or by little.
IncrementalSmoother open_map(int seed, int rounds, double off) {
  SmootherOptions options;
  options.rounds = rounds;
  IncrementalSmoother map(options);
  testing::ChangingWorld world(seed);
  for (int k = 0; k < 12; ++k) world.step(map);
  const SE2 seen = map.values().at<SE2>(pose(1)).between(map.values().at<SE2>(pose(10)));
  Delta delta;
  delta.continuous.push_back(between(1, 10, seen * SE2(off, -off, 0.4 * off), 0.05));
  map.update(delta);
  return map;
}

/// Settling ends where nothing is left to gain: neither before, nor long after.
TEST(Settle, LeavesNextToNothingAndThenEnds) {
  int open = 0;
  for (int seed = 1; seed <= 10; ++seed) {
    for (const int rounds : {1, 3}) {
      for (const double off : {1.0, 5.0}) {
        SCOPED_TRACE("seed " + std::to_string(seed) + ", rounds " + std::to_string(rounds) +
                     ", off by " + std::to_string(off));
        IncrementalSmoother map = open_map(seed, rounds, off);
        const double before = map.objective();
        map.settle();
        const double settled = map.objective();
        open += settled < before - 1.0 ? 1 : 0;
        const UpdateReport again = map.settle();
        EXPECT_GE(map.objective(), settled - 0.01);
        EXPECT_LE(map.objective(), settled * (1.0 + 1e-9));
        EXPECT_LE(again.rounds, 2 * rounds);
      }
    }
  }
  EXPECT_GE(open, 20);
}

}  // namespace
}  // namespace hybrid
