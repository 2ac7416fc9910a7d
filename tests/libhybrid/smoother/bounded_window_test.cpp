// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "libhybrid/discrete/inference.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/linear_prior.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/switching/markov.h"
#include "tests/support/bounded_walk.h"
#include "tests/support/changing_world.h"
#include "tests/support/consistency.h"

namespace hybrid {
namespace {

using Eigen::Vector2d;
using testing::bounded;
using testing::count_poses;
using testing::LinearWalk;
using testing::of_vectors;
using testing::PoseError;
using testing::SimulatedWalk;
using testing::WalkOptions;

/// Whether two estimates are the same, bit by bit.
void expect_same(const Values& a, const Values& b) {
  ASSERT_EQ(a.keys(), b.keys());
  for (Key key : a.keys()) {
    const double *x = a.data(key), *y = b.data(key);
    EXPECT_TRUE(std::equal(x, x + a.type(key).size, y)) << to_string(key);
  }
}

TEST(BoundedWindow, IsFullSmoothingToTheLastBitAsLongAsItIsComplete) {
  WindowSmoother full, window(bounded(200, 5));
  SimulatedWalk<SE2> first({}, 3), second({}, 3);
  for (int t = 0; t < 200; ++t) {
    full.update(first.step(full.smoother().values()));
    EXPECT_TRUE(window.update(second.step(window.smoother().values())).left.empty());
  }
  expect_same(full.smoother().values(), window.smoother().values());
  EXPECT_EQ(full.smoother().objective(), window.smoother().objective());
  full.converge();
  window.converge();
  expect_same(full.smoother().values(), window.smoother().values());
  bool left = false;
  for (int t = 0; t < 100; ++t) {
    left = !window.update(second.step(window.smoother().values())).left.empty() || left;
  }
  EXPECT_TRUE(left);
}

// However long the robot stays, the graph is that of the place.
TEST(BoundedWindow, GraphAndMemoryStayAsTheyAreInAKnownPlace) {
  WindowSmoother window(bounded(150, 10));
  SimulatedWalk<SE2> world({}, 5);
  std::size_t poses = 0, factors = 0, bytes = 0;
  for (int t = 0; t < 1500; ++t) {
    const WindowReport report = window.update(world.step(window.smoother().values()));
    ASSERT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
    EXPECT_TRUE(report.kept.empty()) << report.kept_because;
    const IncrementalSmoother& smoother = window.smoother();
    std::size_t& most_poses = poses;
    if (t < 500) {
      most_poses = std::max(most_poses, count_poses(smoother.values()));
      factors = std::max(factors, smoother.graph().size());
      bytes = std::max(bytes, smoother.memory().bytes);
    } else {
      EXPECT_LE(count_poses(smoother.values()), poses);
      EXPECT_LE(smoother.graph().size(), factors + factors / 4);
      EXPECT_LE(smoother.memory().bytes, bytes + bytes / 4);
    }
  }
  EXPECT_EQ(window.past().values.size() + count_poses(window.smoother().values()), 1500u);
  for (Key key : window.past().values.keys()) {
    ASSERT_NE(window.past_covariance(key), nullptr);
    EXPECT_GT(window.past_covariance(key)->determinant(), 0.0);
  }
}

// A change is judged by the objective before and after: what leaves has to wait.
TEST(BoundedWindow, KeepsAllWhereAChangeIsOnTrial) {
  constexpr double kAnyRise = std::numeric_limits<double>::infinity();
  WindowSmoother window(bounded(60, 5));
  SimulatedWalk<SE2> world({}, 3);
  for (int t = 0; t < 150; ++t) {
    const WindowReport report = window.propose({world.step(window.smoother().values()), kAnyRise});
    ASSERT_EQ(report.status, UpdateReport::Status::kOk);
    EXPECT_TRUE(report.left.empty());
  }
  const double before = window.smoother().objective();
  EXPECT_TRUE(window.propose({{}, kAnyRise}).left.empty());
  EXPECT_NEAR(window.smoother().objective(), before, 1e-3);
  EXPECT_EQ(window.update({}).left.size(), 50U);
  EXPECT_GT(std::abs(window.smoother().objective() - before), 10.0);
}

// What a proposal would have brought back into the graph stays past where it is turned down.
TEST(BoundedWindow, IsAsBeforeWhereAChangeIsTurnedDown) {
  WindowSmoother window(bounded(60, 5)), twin(bounded(60, 5));
  SimulatedWalk<SE2> world({}, 3), same({}, 3);
  for (int t = 0; t < 150; ++t) {
    window.update(world.step(window.smoother().values()));
    twin.update(same.step(twin.smoother().values()));
  }
  ASSERT_FALSE(window.past().values.empty());
  const Key past = window.past().values.keys().front();
  const Key newest('x', 149);
  ASSERT_TRUE(window.smoother().values().contains(newest));
  // What enters again is free but for what the proposal says, so that has to contradict itself.
  Proposal wrong;
  for (const double x : {-100, 100}) {
    wrong.delta.continuous.push_back(
        std::make_shared<BetweenSE2>(past, newest, SE2(x, 0, 0), Noise::isotropic(3, 0.01)));
  }
  wrong.allowed_rise = 5;
  const WindowReport report = window.propose(wrong);
  EXPECT_EQ(report.status, UpdateReport::Status::kTurnedDown);
  EXPECT_EQ(testing::state(window.smoother()), testing::state(twin.smoother()));
  EXPECT_TRUE(window.past().values.contains(past));
  for (int t = 0; t < 20; ++t) {
    const WindowReport one = window.update(world.step(window.smoother().values()));
    EXPECT_EQ(one.left, twin.update(same.step(twin.smoother().values())).left);
  }
  EXPECT_EQ(testing::state(window.smoother()), testing::state(twin.smoother()));
}

// What is newly explored stays, and of a place as many sightings of each landmark as are asked for.
TEST(BoundedWindow, KeepsTheNewestSightingsOfEachLandmark) {
  const int sightings = 7;
  WindowSmoother window(bounded(100, sightings));
  SimulatedWalk<SE2> world({}, 8);
  std::map<Key, int> seen;
  for (int t = 0; t < 600; ++t) {
    const Delta delta = world.step(window.smoother().values());
    for (const auto& factor : delta.continuous) {
      for (Key key : factor->keys()) seen[key] += key.letter() == 'l' ? 1 : 0;
    }
    window.update(delta);
  }
  for (const auto& [key, count] : seen) {
    if (key.letter() != 'l') continue;
    int here = 0;
    for (Handle handle : window.smoother().factors_of(key)) {
      const ContinuousFactor& factor = *window.smoother().graph().continuous().at(handle);
      here += dynamic_cast<const LinearPrior*>(&factor) == nullptr ? 1 : 0;
    }
    EXPECT_GE(here, std::min(count, sightings)) << to_string(key);
  }
}

// A second robot stands while the first goes on. Nothing but its newest pose tells where it is.
TEST(BoundedWindow, KeepsTheEndOfEachChain) {
  WindowSmoother window(bounded(100, 5));
  SimulatedWalk<SE2> world({}, 8);
  const SE2 metre(1, 0, 0);
  std::uint64_t standing = 0;
  const auto drive_the_other = [&] {
    Delta delta;
    const Key to('y', standing);
    delta.values.insert(to, SE2(static_cast<double>(standing), 0, 0));
    if (standing == 0) {
      delta.continuous.push_back(
          std::make_shared<Prior<SE2>>(to, SE2(), Noise::isotropic(3, 0.01)));
    } else {
      delta.continuous.push_back(std::make_shared<BetweenSE2>(Key('y', standing - 1), to, metre,
                                                              Noise::isotropic(3, 0.01)));
    }
    ++standing;
    const WindowReport report = window.update(delta);
    EXPECT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
  };
  for (int i = 0; i < 3; ++i) drive_the_other();
  for (int t = 0; t < 400; ++t) window.update(world.step(window.smoother().values()));
  EXPECT_TRUE(window.past().values.contains(Key('y', 1)));
  for (int i = 0; i < 3; ++i) drive_the_other();
  EXPECT_NEAR(window.smoother().values().at<SE2>(Key('y', 5)).translation().x(), 5.0, 0.01);
}

// Where all is linear, nothing is lost.
TEST(BoundedWindow, EqualsBatchOnALinearProblem) {
  WindowSmoother window(of_vectors(bounded(60, 5)));
  IncrementalSmoother full;
  LinearWalk first(2, 12), second(2, 12);
  for (int t = 0; t < 400; ++t) window.update(first.step());
  window.converge();
  full.update(second.steps(400));
  full.converge();
  EXPECT_LT(window.smoother().values().size(), 150u);
  EXPECT_EQ(window.divergence(), 0.0);
  const std::vector<Key> keys = window.smoother().values().keys();
  for (Key key : keys) {
    EXPECT_LT(
        (window.smoother().values().at<Vector2d>(key) - full.values().at<Vector2d>(key)).norm(),
        1e-7)
        << to_string(key);
  }
  const Eigen::MatrixXd expected = full.joint_covariance(keys);
  EXPECT_LT((window.smoother().joint_covariance(keys) - expected).norm(), 1e-7 * expected.norm());
}

/// NEES and squared error of the newest pose, means over runs and steps.
struct Score {
  double nees = 0.0, squares = 0.0;
};

template <class Pose>
Score score(const WindowOptions& window, const WalkOptions& options, int runs, int steps) {
  Score sum;
  for (int run = 0; run < runs; ++run) {
    testing::walk<Pose>(window, options, steps, 500 + static_cast<std::uint64_t>(run),
                        [&](int, const WindowSmoother&, const PoseError& error) {
                          sum.nees += error.nees / (runs * steps);
                          sum.squares += error.distance * error.distance / (runs * steps);
                        });
  }
  return sum;
}

/// Against full smoothing of the same 30 runs.
template <class Pose>
void expect_as_good_as_full(const WindowOptions& window, const WalkOptions& options, int steps) {
  const Score full = score<Pose>({}, options, 30, steps);
  const Score here = score<Pose>(window, options, 30, steps);
  EXPECT_NEAR(full.nees, 1.0, 0.25);
  EXPECT_GT(here.nees, 0.8 * full.nees);
  EXPECT_LT(here.nees, 1.25 * full.nees);
  EXPECT_LT(std::sqrt(here.squares), 1.05 * std::sqrt(full.squares));
}

TEST(BoundedWindow, IsAsGoodAndAsSureAsFullSmoothingInThePlane) {
  expect_as_good_as_full<SE2>(bounded(130, 10), {}, 300);
}

TEST(BoundedWindow, IsAsGoodAndAsSureAsFullSmoothingInSpace) {
  WalkOptions options;
  options.landmarks = 40;
  options.spread = 6.0;
  expect_as_good_as_full<SE3>(bounded(100, 10), options, 160);
}

/// Wheels that slip at times, in a chain of modes, beside four landmarks: in mode 1 the robot comes
/// half as far as it should.
Delta slip_step(int t, const Values& estimate, testing::Random& random, SE2& truth) {
  static const MarkovChain chain = sticky_chain(2, 0.8);
  const SE2 command(0.5, 0.0, 0.1), half(0.25, 0.0, 0.05);
  const Key now('x', static_cast<std::uint64_t>(t));
  Delta delta;
  SE2 start;
  if (t == 0) {
    delta.continuous.push_back(std::make_shared<Prior<SE2>>(now, SE2(), Noise::isotropic(3, 0.01)));
  } else {
    const Key before('x', static_cast<std::uint64_t>(t - 1));
    const DiscreteKey mode{Key('m', static_cast<std::uint64_t>(t)), 2};
    const bool slips = (t / 6) % 3 == 2;
    truth = truth * (slips ? half : command) * random.value<SE2>(slips ? 0.1 : 0.05);
    start = estimate.at<SE2>(before) * command;
    delta.hybrid.push_back(std::make_shared<Mixture>(
        std::vector<DiscreteKey>{mode},
        std::vector<MixtureComponent>{
            {std::make_shared<BetweenSE2>(before, now, command, Noise::isotropic(3, 0.05))},
            {std::make_shared<BetweenSE2>(before, now, half, Noise::isotropic(3, 0.1))}}));
    const DiscreteKey last{Key('m', static_cast<std::uint64_t>(t - 1)), 2};
    delta.discrete.push_back(t == 1 ? chain_tables(chain, {mode}).front()
                                    : chain_step(chain, last, mode));
  }
  delta.values.insert(now, start);
  for (int l = 0; l < 4; ++l) {
    const Key landmark('l', static_cast<std::uint64_t>(l));
    const Vector2d point(l < 2 ? -3.0 : 3.0, l % 2 == 0 ? 0.0 : 8.0);
    Vector2d z = to_polar(Vector2d(truth.inverse() * point));
    z += Vector2d(random.normal(0.2), random.normal(0.05));
    if (t == 0) delta.values.insert(landmark, point);
    delta.continuous.push_back(
        std::make_shared<BearingRange2>(now, landmark, z, Noise::diagonal(Vector2d(0.2, 0.05))));
  }
  return delta;
}

// Modes of motion that leave are fixed at their values; the loss is -log p of them, exactly.
TEST(BoundedWindow, FixesTheModesThatLeaveAndSaysWhatThatLoses) {
  testing::Random random(4);
  SE2 truth;
  WindowSmoother window(bounded(120, 5));
  double divergence = 0.0;
  for (int t = 0; t < 240; ++t) {
    const Delta delta = slip_step(t, window.smoother().values(), random, truth);
    IncrementalSmoother before = window.smoother();
    const WindowReport report = window.update(delta);
    ASSERT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
    ASSERT_TRUE(report.kept.empty()) << report.kept_because;
    divergence += report.divergence;
    if (report.left_discrete.empty()) {
      EXPECT_EQ(report.divergence, 0.0);
      continue;
    }
    before.update(delta);  // what was there when they left
    const std::vector<const Table*> tables = before.component(report.left_discrete.front());
    std::vector<Table> held;
    Assignment values;
    for (Key key : report.left_discrete) values.set(key, window.past().assignment.at(key));
    for (const Table* table : tables) held.push_back(condition(*table, values));
    std::vector<const Table*> rest;
    for (const Table& table : held) rest.push_back(&table);
    const DiscreteMarginals expected = discrete_marginals(tables);
    EXPECT_NEAR(report.divergence,
                expected.log_partition() - discrete_marginals(rest).log_partition(), 1e-6);
    for (Key key : report.left_discrete) {
      ASSERT_NE(window.past_table(key), nullptr);
      const DiscreteMarginals here = discrete_marginals({window.past_table(key)});
      EXPECT_LT((expected.at(key) - here.at(key)).norm(), 1e-6) << to_string(key);
    }
  }
  EXPECT_GT(divergence, 0.0);
  EXPECT_EQ(divergence, window.divergence());
  // None of them is left behind.
  for (const auto& [key, value] : window.smoother().assignment()) {
    EXPECT_TRUE(window.smoother().values().contains(Key('x', key.index()))) << to_string(key);
  }
}

}  // namespace
}  // namespace hybrid
