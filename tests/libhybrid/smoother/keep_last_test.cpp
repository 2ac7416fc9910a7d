// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Variables that are kept last in the elimination.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/smoother/transaction.h"
#include "tests/support/changing_world.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::pose;
using testing::state;
using World = testing::ChangingWorld;

/// Whether nothing is eliminated behind some variables, or behind what is, but they themselves.
bool come_last(const IncrementalSmoother& smoother, const std::vector<Key>& keys) {
  const auto named = [&](int slot) {
    return std::count(keys.begin(), keys.end(), smoother.values().key(slot)) != 0;
  };
  const std::vector<std::pair<int, int>> blocks = smoother.tree().cliques().blocks();
  return std::none_of(blocks.begin(), blocks.end(), [&](const std::pair<int, int>& block) {
    return named(block.second) && !named(block.first);
  });
}

/// A straight path of poses, one by one.
IncrementalSmoother corridor(int poses, const std::vector<Key>& kept) {
  SmootherOptions options;
  options.defer = 0.0;
  IncrementalSmoother smoother(options);
  smoother.keep_last(kept);
  for (int k = 0; k < poses; ++k) {
    Delta delta;
    delta.values.insert(pose(k), SE2(k, 0.0, 0.0));
    delta.continuous.push_back(
        k == 0 ? std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 0.01))
               : testing::between(k - 1, k, SE2(1.0, 0.0, 0.0), 0.05));
    EXPECT_EQ(smoother.update(delta).status, UpdateReport::Status::kOk);
  }
  return smoother;
}

Delta position_of(int k) {
  Delta delta;
  delta.continuous.push_back(
      std::make_shared<Prior<SE2>>(pose(k), SE2(k, 0.01, 0.0), Noise::isotropic(3, 0.1)));
  return delta;
}

TEST(KeepLast, NamedVariablesAreEliminatedAfterAllOthers) {
  const std::vector<Key> kept = {testing::landmark(1), pose(4), pose(11)};  // not known yet
  for (int seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    World world(seed);
    IncrementalSmoother smoother;
    ASSERT_EQ(smoother.keep_last(kept).status, UpdateReport::Status::kOk);
    for (int k = 0; k < 40; ++k) {
      ASSERT_EQ(world.step(smoother).status, UpdateReport::Status::kOk);
      ASSERT_TRUE(come_last(smoother, kept)) << k;
    }
    smoother.converge();
    EXPECT_TRUE(come_last(smoother, kept));
  }
}

TEST(KeepLast, MovesWhatIsDeepInTheTreeAndLiftsItAgain) {
  IncrementalSmoother smoother = corridor(60, {});
  EXPECT_FALSE(come_last(smoother, {pose(7), pose(30)}));
  const std::vector<double> estimate = smoother.snapshot().numbers;
  const Eigen::MatrixXd P = smoother.joint_covariance({pose(7), pose(30), pose(59)});
  const UpdateReport report = smoother.keep_last({pose(30), pose(7)});
  EXPECT_EQ(report.status, UpdateReport::Status::kOk);
  EXPECT_TRUE(come_last(smoother, {pose(7), pose(30)}));
  EXPECT_EQ(smoother.snapshot().numbers, estimate);
  const Eigen::MatrixXd after = smoother.joint_covariance({pose(7), pose(30), pose(59)});
  EXPECT_LT((after - P).norm(), 1e-9 * P.norm());
  smoother.keep_last({});
  for (int k = 0; k < 3; ++k) smoother.update(position_of(20));
  EXPECT_FALSE(come_last(smoother, {pose(7), pose(30)}));
}

/// A random graph of points, grown one by one. It is linear, so that nothing but the order differs.
IncrementalSmoother points(int seed, const std::vector<Key>& kept) {
  testing::Random random(seed);
  SmootherOptions options;
  options.wildfire = 0.0;
  options.bend = options.bend_share = 0.0;
  IncrementalSmoother smoother(options);
  smoother.keep_last(kept);
  for (int k = 0; k < 80; ++k) {
    Delta delta;
    delta.values.insert(pose(k), Eigen::Vector2d(k, 0.0));
    if (k == 0) {
      delta.continuous.push_back(std::make_shared<Prior<Eigen::Vector2d>>(
          pose(0), Eigen::Vector2d(0.0, 0.0), Noise::isotropic(2, 0.01)));
    }
    for (int old : {k - 1, random.below(k + 1), random.below(k + 1)}) {
      if (old < 0 || old == k) continue;
      const Eigen::Vector2d z(k - old + random.uniform(), random.uniform());
      delta.continuous.push_back(std::make_shared<Between<Eigen::Vector2d>>(
          pose(old), pose(k), z, Noise::isotropic(2, 0.1 + random.uniform())));
    }
    EXPECT_EQ(smoother.update(delta).status, UpdateReport::Status::kOk);
  }
  return smoother;
}

TEST(KeepLast, ResultsAreThoseOfAnyOtherOrder) {
  for (int seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const IncrementalSmoother free = points(seed, {});
    const IncrementalSmoother held = points(seed, {pose(3), pose(41), pose(60)});
    EXPECT_TRUE(come_last(held, {pose(3), pose(41), pose(60)}));
    EXPECT_NE(free.elimination_order(), held.elimination_order());
    EXPECT_NEAR(held.objective(), free.objective(), 1e-9 * std::abs(free.objective()));
    for (Key key : free.values().keys()) {
      EXPECT_LT((held.values().vector(key) - free.values().vector(key)).norm(), 1e-9);
    }
    EXPECT_NEAR(held.tree().log_determinant(), free.tree().log_determinant(), 1e-8);
    const Eigen::MatrixXd P = free.joint_covariance({pose(3), pose(79)});
    EXPECT_LT((held.joint_covariance({pose(3), pose(79)}) - P).norm(), 1e-9 * P.norm());
  }
}

TEST(KeepLast, ChangesOfNamedVariablesCostLittle) {
  constexpr int kPoses = 400;
  IncrementalSmoother free = corridor(kPoses, {});
  IncrementalSmoother held = corridor(kPoses, {pose(5)});
  const int without = free.update(position_of(5)).eliminated;
  const int with = held.update(position_of(5)).eliminated;
  EXPECT_GT(without, 50);
  EXPECT_LT(with, 25);  // the newest ten poses are up there as well
}

TEST(KeepLast, IsRolledBack) {
  World world(4);
  IncrementalSmoother smoother;
  for (int k = 0; k < 15; ++k) world.step(smoother);
  const std::vector<double> before = state(smoother);
  IncrementalSmoother twin = smoother;
  World other = world;
  {
    const Transaction trial(smoother);
    smoother.keep_last({pose(1)});
    ASSERT_TRUE(come_last(smoother, {pose(1)}));
  }
  ASSERT_EQ(state(smoother), before);
  for (int k = 0; k < 5; ++k) {
    world.step(smoother);
    other.step(twin);
  }
  EXPECT_EQ(state(smoother), state(twin));
}

}  // namespace
}  // namespace hybrid
