// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Updates are all or nothing, and transactions leave no trace when they are rolled back.
#include "libhybrid/smoother/transaction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/changing_world.h"
#include "tests/support/fragile_factor.h"

namespace hybrid {
namespace {

using testing::between;
using testing::closure_switch;
using testing::FragileFactor;
using testing::pose;
using testing::state;
using World = testing::ChangingWorld;

TEST(Transaction, RollBackLeavesNoTrace) {
  int flips = 0;
  for (int seed = 1; seed <= 15; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    World world(seed);
    IncrementalSmoother smoother;
    for (int k = 0; k < 25; ++k) {
      const IncrementalSmoother twin_smoother = smoother;
      const World twin_world = world;
      const std::vector<double> before = state(smoother);
      {
        const Transaction trial(smoother);
        world.seed(100 * seed + k);
        for (int n = 0; n <= k % 4; ++n) flips += world.step(smoother).flips;
        if (k % 5 == 0) smoother.converge(3);
      }
      ASSERT_FALSE(smoother.in_transaction());
      ASSERT_EQ(state(smoother), before);
      world = twin_world;
      // What comes next is the same as if nothing had been tried.
      IncrementalSmoother twin = twin_smoother;
      World other = twin_world;
      other.step(twin);
      other.step(twin);
      world.step(smoother);
      world.step(smoother);
      ASSERT_EQ(state(smoother), state(twin));
    }
  }
  EXPECT_GT(flips, 100);
}

TEST(Transaction, CommitKeepsAllThatWasDone) {
  for (int seed = 1; seed <= 5; ++seed) {
    World world(seed);
    IncrementalSmoother smoother;
    for (int k = 0; k < 8; ++k) {
      IncrementalSmoother twin = smoother;
      World other = world;
      Transaction trial(smoother);
      for (int n = 0; n < 3; ++n) world.step(smoother);
      trial.commit();
      for (int n = 0; n < 3; ++n) other.step(twin);
      // Updates that are committed one by one make room earlier for what comes next. So the trees
      // differ, and what else is linearised with a change; what both converge to does not.
      for (IncrementalSmoother* each : {&smoother, &twin}) each->converge();
      EXPECT_NEAR(smoother.objective(), twin.objective(), 1e-6 * std::abs(twin.objective()));
      EXPECT_EQ(smoother.graph().size(), twin.graph().size());
      EXPECT_EQ(smoother.values().size(), twin.values().size());
    }
  }
}

TEST(Transaction, OneAtATime) {
  IncrementalSmoother smoother;
  EXPECT_THROW(smoother.commit(), Error);
  smoother.roll_back();
  smoother.begin();
  EXPECT_THROW(smoother.begin(), Error);
  World(1).step(smoother);
  Delta bad;
  bad.values.insert(pose(0), SE2());  // is there already
  EXPECT_THROW(smoother.update(bad), Error);
  EXPECT_FALSE(smoother.in_transaction());  // an update that fails takes all of it back
  EXPECT_TRUE(smoother.values().empty());
  EXPECT_THROW(smoother.commit(), Error);
}

TEST(Transaction, WhatWasRemovedInItIsGone) {
  World world(1);
  IncrementalSmoother smoother;
  std::vector<Handle> handles = world.step(smoother).handles.all();
  Transaction trial(smoother);
  Delta removal;
  removal.remove = handles;
  removal.remove_values = {pose(0)};
  ASSERT_EQ(smoother.update(removal).status, UpdateReport::Status::kOk);
  EXPECT_THROW(smoother.update(removal), Error);
  EXPECT_EQ(smoother.values().size(), 1u);  // all is back
  EXPECT_EQ(smoother.graph().size(), 1u);
}

TEST(Savepoint, RollBackLeavesNoTraceInTheTransactionNorOfIt) {
  int flips = 0;
  for (int seed = 1; seed <= 15; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    World world(seed);
    IncrementalSmoother smoother;
    for (int k = 0; k < 15; ++k) {
      const IncrementalSmoother outside = smoother;
      const World world_outside = world;
      {
        Transaction trial(smoother);
        for (int n = 0; n < k % 3; ++n) world.step(smoother);
        Savepoint kept(smoother);
        world.step(smoother);
        kept.release();
        const IncrementalSmoother inside = smoother;
        const World world_inside = world;
        const std::vector<double> within = state(smoother);
        for (int times = 0; times < 2; ++times) {
          const Savepoint savepoint(smoother);
          world = world_inside;
          world.seed(100 * seed + 10 * k + times);
          for (int n = 0; n <= k % 4; ++n) flips += world.step(smoother).flips;
          Savepoint inner(smoother);
          flips += world.step(smoother).flips;
          if (k % 2 == 0) inner.release();
          if (k % 5 == 0) smoother.converge(3);
        }
        ASSERT_EQ(state(smoother), within);
        world = world_inside;
        IncrementalSmoother twin = inside;
        World other = world_inside;
        { const Savepoint nothing(twin); }
        for (int n = 0; n < 2; ++n) {
          other.step(twin);
          world.step(smoother);
          ASSERT_EQ(state(smoother), state(twin));
        }
        if (k % 4 == 0) {
          trial.commit();
          continue;
        }
      }
      ASSERT_EQ(state(smoother), state(outside));
      IncrementalSmoother twin = outside;
      World other = world_outside;
      world = world_outside;
      for (int n = 0; n < 2; ++n) {
        other.step(twin);
        world.step(smoother);
      }
      ASSERT_EQ(state(smoother), state(twin));
    }
  }
  EXPECT_GT(flips, 100);
}

TEST(Savepoint, AnUpdateThatFailsGoesBackToTheNewestAlone) {
  World world(1);
  IncrementalSmoother smoother;
  EXPECT_THROW(Savepoint{smoother}, Error);  // in no transaction
  Transaction trial(smoother);
  world.step(smoother);
  const std::vector<double> before = state(smoother);
  Delta bad;
  bad.values.insert(pose(0), SE2());  // is there already
  {
    Savepoint savepoint(smoother);
    world.step(smoother);
    EXPECT_THROW(smoother.update(bad), Error);
    EXPECT_TRUE(smoother.in_transaction());
    EXPECT_EQ(state(smoother), before);
    EXPECT_THROW(savepoint.release(), Error);
  }
  EXPECT_EQ(state(smoother), before);
  trial.commit();
  EXPECT_EQ(state(smoother), before);
}

TEST(Savepoint, AnAttemptThatIsRefusedOrFalseIsUndone) {
  World world(1);
  IncrementalSmoother smoother;
  Transaction trial(smoother);
  world.step(smoother);
  const std::vector<double> before = state(smoother);
  const World world_before = world;
  const auto refused = [&]() -> bool {
    world.step(smoother);
    UpdateReport report;
    report.status = UpdateReport::Status::kSingular;
    taken(report);
    return true;
  };
  EXPECT_FALSE(attempt(smoother, refused));
  EXPECT_EQ(state(smoother), before);
  const auto step = [&](bool keep) {
    world = world_before;
    world.step(smoother);
    return keep;
  };
  EXPECT_FALSE(attempt(smoother, [&] { return step(false); }));
  EXPECT_EQ(state(smoother), before);
  EXPECT_TRUE(attempt(smoother, [&] { return step(true); }));
  EXPECT_NE(state(smoother), before);
}

TEST(AllOrNothing, AFactorThatThrowsAnywhereLeavesTheSmootherAsItWas) {
  const auto fuse = std::make_shared<testing::Fuse>();
  World world(3);
  IncrementalSmoother smoother;
  for (int k = 0; k < 12; ++k) world.step(smoother);
  Delta first;
  for (int i = 1; i < 9; i += 2) {
    first.continuous.push_back(
        std::make_shared<FragileFactor>(between(i, i + 2, SE2(1.9, 0.7, 0.9), 0.3), fuse));
  }
  ASSERT_EQ(smoother.update(first).status, UpdateReport::Status::kOk);
  const std::vector<double> before = state(smoother);
  Delta second;  // moves all, so that everything is linearised and evaluated again
  second.continuous.push_back(
      std::make_shared<FragileFactor>(between(0, 11, SE2(-2.0, 3.0, 2.0), 0.01), fuse));
  int thrown = 0;
  for (int n = 1;; ++n) {
    IncrementalSmoother trial = smoother;
    fuse->arm(n);
    try {
      trial.update(second);
      trial.converge(5);
      break;
    } catch (const std::domain_error&) {
      ++thrown;
    }
    fuse->disarm();
    if (trial.graph().size() == smoother.graph().size()) {
      ASSERT_EQ(state(trial), before) << "at use " << n;
    }
    ASSERT_EQ(trial.update({}).status, UpdateReport::Status::kOk) << "at use " << n;
    ASSERT_TRUE(std::isfinite(trial.objective()));
  }
  EXPECT_GT(thrown, 50);
}

TEST(AllOrNothing, WhatComesAfterAFailureIsTheSameToTheLastBit) {
  for (int seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    World world(seed);
    IncrementalSmoother smoother;
    for (int k = 0; k < 20; ++k) world.step(smoother);
    IncrementalSmoother spared = smoother;
    const auto fuse = std::make_shared<testing::Fuse>();
    Delta change;
    change.continuous.push_back(
        std::make_shared<FragileFactor>(between(2, 9, SE2(-2.0, 3.0, 2.0), 0.1), fuse));
    fuse->arm(3);
    ASSERT_THROW(smoother.update(change), std::domain_error);
    smoother.converge();
    spared.converge();
    EXPECT_EQ(state(smoother), state(spared));
  }
}

/// A component that is not a number on one side of the origin, and is not chosen there.
TEST(AllOrNothing, AnotherComponentThatIsNoNumberIsAnErrorThatChangesNothing) {
  class OneSided : public ContinuousFactor {
   public:
    explicit OneSided(Key key)
        : ContinuousFactor({key}, {Variable<Eigen::Matrix<double, 1, 1>>::type()}, 1) {}
    double cost(const double* const* x) const override {
      return x[0][0] < 0.0 ? std::numeric_limits<double>::quiet_NaN() : 50.0;
    }
    double linearize(const double* const* x, double* r, double* J) const override {
      r[0] = 10.0;
      J[0] = 0.0;
      return cost(x);
    }
    double log_normalizer() const override { return 0.0; }
    std::string name() const override { return "one-sided"; }
  };
  using Scalar = Eigen::Matrix<double, 1, 1>;
  IncrementalSmoother smoother;
  Delta delta;
  const Key x{'x', 0};
  delta.values.insert(x, Scalar(1.0));
  delta.continuous.push_back(std::make_shared<Prior<Scalar>>(x, Scalar(1.0), Noise::unit(1)));
  std::vector<MixtureComponent> components = {
      {std::make_shared<Prior<Scalar>>(x, Scalar(1.0), Noise::unit(1)), 0.0, false},
      {std::make_shared<OneSided>(x), 0.0, false}};
  delta.hybrid.push_back(
      std::make_shared<Mixture>(std::vector<DiscreteKey>{closure_switch(0)}, components));
  ASSERT_EQ(smoother.update(delta).status, UpdateReport::Status::kOk);
  const std::vector<double> before = state(smoother);
  Delta pull;
  pull.continuous.push_back(
      std::make_shared<Prior<Scalar>>(x, Scalar(-50.0), Noise::isotropic(1, 0.01)));
  EXPECT_THROW(smoother.update(pull), Error);
  EXPECT_EQ(state(smoother), before);
  EXPECT_EQ(smoother.update({}).status, UpdateReport::Status::kOk);
}

}  // namespace
}  // namespace hybrid
