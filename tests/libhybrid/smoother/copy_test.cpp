// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// A copy of a smoother is an independent smoother.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "libhybrid/smoother/incremental.h"
#include "tests/support/changing_world.h"

namespace hybrid {
namespace {

using testing::state;
using World = testing::ChangingWorld;

/// A smoother and the world that it has seen so far.
struct Journey {
  explicit Journey(int seed, int steps) : world(seed) { go(steps); }
  void go(int steps) {
    for (int k = 0; k < steps; ++k) world.step(smoother);
  }
  World world;
  IncrementalSmoother smoother;
};

TEST(Copy, WhatIsDoneToOneLeavesTheOtherAsItIs) {
  for (int seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Journey original(seed, 20);
    const std::vector<double> before = state(original.smoother);
    Journey copy = original;
    EXPECT_EQ(state(copy.smoother), before);
    copy.world.seed(100 + seed);
    copy.go(12);
    copy.smoother.converge();
    EXPECT_EQ(state(original.smoother), before);
    const std::vector<double> there = state(copy.smoother);
    EXPECT_NE(there, before);
    original.go(12);
    EXPECT_EQ(state(copy.smoother), there);
  }
}

TEST(Copy, DoesTheSameToTheLastBit) {
  for (int seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Journey original(seed, 20);
    Journey copy = original;
    for (int k = 0; k < 40; ++k) {
      original.go(1);
      copy.go(1);
      ASSERT_EQ(state(copy.smoother), state(original.smoother)) << k;
    }
    // Also what was copied from a copy, and into a smoother that was in use.
    Journey other(seed + 1, 15);
    other = copy;
    for (Journey* one : {&original, &other}) {
      one->go(10);
      one->smoother.converge();
    }
    EXPECT_EQ(state(other.smoother), state(original.smoother));
  }
}

TEST(Copy, OfOneInATransactionIsInThatTransaction) {
  for (int seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Journey original(seed, 15);
    const Journey start = original;
    original.smoother.begin();
    original.go(5);
    Journey copy = original;
    ASSERT_TRUE(copy.smoother.in_transaction());
    copy.go(3);
    original.go(3);
    EXPECT_EQ(state(copy.smoother), state(original.smoother));

    copy.smoother.roll_back();
    EXPECT_EQ(state(copy.smoother), state(start.smoother));
    EXPECT_TRUE(original.smoother.in_transaction());
    original.smoother.commit();
    Journey again = start;
    copy.world = start.world;
    again.go(10);
    copy.go(10);
    EXPECT_EQ(state(copy.smoother), state(again.smoother));
  }
}

}  // namespace
}  // namespace hybrid
