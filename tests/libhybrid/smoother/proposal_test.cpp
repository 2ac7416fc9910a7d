// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/proposal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/smoother/transaction.h"
#include "tests/support/changing_world.h"

namespace hybrid {
namespace {

using testing::between;
using testing::pose;
using testing::state;
using Status = UpdateReport::Status;
using World = testing::ChangingWorld;

/// A map after some steps.
IncrementalSmoother map_of(World& world, int steps = 12) {
  IncrementalSmoother smoother;
  for (int k = 0; k < steps; ++k) world.step(smoother);
  return smoother;
}

/// A measurement that is as wrong as can be, or next to right.
Proposal closure(const IncrementalSmoother& map, bool right, double allowed_rise) {
  const SE2 seen = map.values().at<SE2>(pose(1)).between(map.values().at<SE2>(pose(10)));
  const SE2 z = right ? seen * SE2(0.01, 0, 0) : seen * SE2(5, -5, 2);
  return {{{between(1, 10, z, 0.05)}, {}, {}, {}, {}, {}, {}}, allowed_rise};
}

TEST(Propose, KeepsWhatTheMapBearsOut) {
  for (int seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    World world(seed);
    IncrementalSmoother map = map_of(world);
    IncrementalSmoother twin = map;
    const double before = map.objective();  // settling does not raise it
    const Proposal proposal = closure(map, true, 2.0);
    const UpdateReport report = propose(map, proposal);
    ASSERT_EQ(report.status, Status::kOk) << report.message;
    EXPECT_FALSE(map.in_transaction());
    EXPECT_LE(map.objective(), before + 2.0);
    EXPECT_EQ(report.objective_after, map.objective());
    ASSERT_EQ(report.handles.continuous.size(), 1U);
    EXPECT_TRUE(map.graph().contains(report.handles.continuous[0]));
    // It is the change of a settled map, and what settling makes of it.
    Transaction same(twin);
    twin.settle();
    twin.update(proposal.delta);
    twin.settle();
    same.commit();
    EXPECT_EQ(state(map), state(twin));
  }
}

TEST(Propose, LeavesNoTraceOfWhatItTurnsDown) {
  int moved = 0;
  for (int seed = 1; seed <= 10; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    World world(seed);
    IncrementalSmoother map = map_of(world);
    IncrementalSmoother twin = map;
    World other = world;
    const std::vector<double> before = state(map);
    const UpdateReport report = propose(map, closure(map, false, 2.0));
    EXPECT_EQ(report.status, Status::kTurnedDown);
    EXPECT_NE(report.message.find("where 2 is allowed"), std::string::npos) << report.message;
    moved += report.eliminated;
    EXPECT_EQ(report.objective_after, map.objective());
    EXPECT_EQ(report.handles.size(), 0U);
    EXPECT_TRUE(report.changed.empty());
    ASSERT_EQ(state(map), before);
    // What comes next is the same as if nothing had been tried.
    for (int k = 0; k < 3; ++k) {
      world.step(map);
      other.step(twin);
    }
    EXPECT_EQ(state(map), state(twin));
  }
  EXPECT_GT(moved, 0);
}

/// A pose that is at 0 or at 10, of which the second costs less by 5.
IncrementalSmoother two_places() {
  const DiscreteKey which{Key('m', 0), 2};
  const auto at = [](double x) {
    return std::make_shared<Prior<SE2>>(pose(0), SE2(x, 0, 0), Noise::isotropic(3, 0.1));
  };
  Delta delta;
  delta.values.insert(pose(0), SE2());
  delta.hybrid.push_back(std::make_shared<Mixture>(
      std::vector<DiscreteKey>{which}, std::vector<MixtureComponent>{{at(0), 5}, {at(10), 0}}));
  IncrementalSmoother smoother;
  smoother.update(delta);
  return smoother;
}

Proposal moved_to(double x) {
  Proposal proposal;
  proposal.moved.insert(pose(0), SE2(x, 0, 0));
  return proposal;
}

TEST(Propose, MovesOutOfAPlaceThatHalfStepsDoNotLeave) {
  IncrementalSmoother map = two_places();
  ASSERT_NEAR(map.values().at<SE2>(pose(0)).x(), 0, 1e-6);
  EXPECT_EQ(propose(map, moved_to(9)).status, Status::kOk);
  EXPECT_NEAR(map.values().at<SE2>(pose(0)).x(), 10, 1e-6);
  EXPECT_EQ(map.assignment().at(Key('m', 0)), 1);
  const std::vector<double> before = state(map);
  EXPECT_EQ(propose(map, moved_to(1)).status, Status::kTurnedDown);
  EXPECT_EQ(state(map), before);
}

TEST(Propose, RefusesToMoveWhatIsNotThere) {
  IncrementalSmoother map = two_places();
  const std::vector<double> before = state(map);
  Proposal unknown, other;
  unknown.moved.insert(pose(7), SE2());
  other.moved.insert(pose(0), Eigen::Vector2d(1, 2).eval());
  EXPECT_THROW(propose(map, unknown), Error);
  EXPECT_THROW(propose(map, other), Error);
  EXPECT_FALSE(map.in_transaction());
  EXPECT_EQ(state(map), before);
}

TEST(Propose, JudgesByWhatIsAllowed) {
  World world(3);
  IncrementalSmoother map = map_of(world);
  IncrementalSmoother settled = map;
  Transaction trial(settled);
  settled.settle();
  const double before = settled.objective();
  settled.update(closure(map, false, 0).delta);
  settled.settle();
  const double rise = settled.objective() - before;
  ASSERT_GT(rise, 10.0);
  EXPECT_EQ(propose(map, closure(map, false, rise * 0.999)).status, Status::kTurnedDown);
  EXPECT_EQ(propose(map, closure(map, false, rise * 1.001)).status, Status::kOk);
}

// A change that costs 1 and moves nothing, on a map of which the last update has left much undone.
TEST(Propose, JudgesByNothingThatEarlierUpdatesHaveLeft) {
  World world(5);
  SmootherOptions hasty;
  hasty.rounds = 1;
  IncrementalSmoother map(hasty);
  for (int k = 0; k < 12; ++k) world.step(map);
  const double raised = map.update(closure(map, false, 0).delta).objective_after;
  IncrementalSmoother settled = map;
  settled.settle();
  ASSERT_LT(settled.objective(), raised - 10.0);
  Proposal costs;
  costs.delta.discrete.emplace_back(std::vector<DiscreteKey>{}, std::vector<double>{1.0});
  costs.allowed_rise = 0.99;
  EXPECT_EQ(propose(map, costs).status, Status::kTurnedDown);
  EXPECT_EQ(map.objective(), raised);
  costs.allowed_rise = 1.01;
  EXPECT_EQ(propose(map, costs).status, Status::kOk);
}

TEST(Propose, AChangeThatLeavesAVariableFreeIsSingular) {
  World world(1);
  IncrementalSmoother map = map_of(world);
  const std::vector<double> before = state(map);
  Proposal free;
  free.delta.values.insert(pose(99), SE2());
  free.allowed_rise = 1e9;
  const UpdateReport report = propose(map, free);
  EXPECT_EQ(report.status, Status::kSingular);
  EXPECT_EQ(report.under_constrained, pose(99));
  EXPECT_FALSE(map.in_transaction());
  EXPECT_EQ(state(map), before);
}

TEST(Propose, BadInputThrowsAndChangesNothing) {
  World world(1);
  IncrementalSmoother map = map_of(world);
  const std::vector<double> before = state(map);
  Proposal bad;
  bad.delta.values.insert(pose(0), SE2());  // is there already
  EXPECT_THROW(propose(map, bad), Error);
  EXPECT_FALSE(map.in_transaction());
  EXPECT_EQ(state(map), before);
  map.begin();
  EXPECT_THROW(propose(map, {}), Error);
  EXPECT_TRUE(map.in_transaction());
}

// Not a number is no reason to keep a change.
TEST(Propose, KeepsNothingByANumberThatIsNone) {
  World world(1);
  IncrementalSmoother map = map_of(world);
  EXPECT_EQ(propose(map, closure(map, true, std::nan(""))).status, Status::kTurnedDown);
}

}  // namespace
}  // namespace hybrid
