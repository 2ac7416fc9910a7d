// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/worker_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

namespace hybrid {
namespace {

TEST(WorkerPool, RunsEveryIndexOnceRoundAfterRound) {
  WorkerPool pool(3);
  EXPECT_EQ(pool.threads(), 3);
  for (int count : {0, 1, 2, 3, 100, 1000}) {
    std::vector<int> runs(count, 0);
    for (int round = 0; round < 20; ++round) pool.run(count, [&](int i) { ++runs[i]; });
    EXPECT_EQ(std::count(runs.begin(), runs.end(), 20), count);
  }
}

TEST(WorkerPool, OneThreadIsTheCaller) {
  WorkerPool alone(1);
  std::vector<int> order;
  alone.run(5, [&](int i) { order.push_back(i); });
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3, 4}));
  EXPECT_GE(WorkerPool(0).threads(), 1);
  EXPECT_LE(WorkerPool(0).threads(), 4);
  WorkerPool several(4);
  order.clear();
  several.run(
      5, [&](int i) { order.push_back(i); }, false);
  EXPECT_EQ(order, (std::vector<int>{0, 1, 2, 3, 4}));
}

struct Failure : std::runtime_error {
  explicit Failure(int index) : std::runtime_error("at " + std::to_string(index)), index(index) {}
  int index;
};

TEST(WorkerPool, TheFirstExceptionReachesTheCallerAsItIs) {
  for (int threads : {1, 2, 4}) {
    WorkerPool pool(threads);
    for (int round = 0; round < 50; ++round) {
      try {
        pool.run(200, [&](int i) {
          if (i % 7 == 5) throw Failure(i);
        });
        FAIL() << "no exception";
      } catch (const Failure& failure) {
        EXPECT_EQ(failure.index, 5) << threads;
      }
      // The pool goes on.
      std::atomic<int> sum = 0;
      pool.run(10, [&](int i) { sum += i; });
      EXPECT_EQ(sum, 45);
    }
  }
}

TEST(WorkerPool, LoopsMayRunInsideLoopsOfTheSameAndOfOtherPools) {
  WorkerPool outer(3), inner(2);
  std::vector<std::vector<int>> seen(20, std::vector<int>(30, 0));
  outer.run(20, [&](int i) {
    inner.run(30, [&](int j) { ++seen[i][j]; });
    outer.run(30, [&](int j) { ++seen[i][j]; });
    EXPECT_THROW(inner.run(3, [](int j) { throw Failure(j); }), Failure);
  });
  for (const auto& row : seen) EXPECT_EQ(row, std::vector<int>(30, 2));
}

}  // namespace
}  // namespace hybrid
