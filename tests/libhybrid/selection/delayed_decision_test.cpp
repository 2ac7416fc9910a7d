// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/selection/delayed_decision.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/position.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/pose_graph/pose_feed.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::pose;
using testing::random_motion;

/// Three laps on a circle, every step measured with small noise, every second pose recognised a lap
/// later; every `every`-th step has a second hypothesis.
PoseGraph laps(int every, unsigned seed) {
  constexpr int kLap = 30;
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> far(-2.0, 2.0);
  const Noise noise = Noise::isotropic(3, 0.02);
  const SE2 step(1.0, 0.0, 2 * M_PI / kLap);
  PoseGraph graph;
  std::vector<SE2> truth(1);
  for (int i = 1; i < 3 * kLap; ++i) {
    truth.push_back(truth.back() * step);
    graph.poses2.push_back({pose(i - 1), pose(i), step * random_motion<SE2>(0.01, rng), noise});
    if (i % every == 0) {
      graph.alternatives.push_back(
          {graph.poses2.size() - 1, {step * SE2(far(rng), far(rng), far(rng))}});
    }
    if (i >= kLap && i % 2 == 0) {
      const SE2 z = truth[i - kLap].between(truth[i]) * random_motion<SE2>(0.01, rng);
      graph.poses2.push_back({pose(i - kLap), pose(i), z, noise});
    }
  }
  return graph;
}

/// Feeds a graph to a decisions; the most closures that waited at a time.
std::size_t feed_all(const PoseGraph& graph, DelayedDecisionSmoother& decisions) {
  std::size_t waited = 0;
  PoseFeed feed(graph, initialize_from_odometry(graph));
  while (!feed.done()) {
    const UpdateReport report = decisions.update(feed.next(decisions.smoother().values()));
    EXPECT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
    waited = std::max(waited, decisions.waiting());
  }
  return waited;
}

TEST(DelayedDecisionSmoother, FindsTheTrueHypothesesOnline) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    PoseGraph graph = laps(11, seed);
    const std::vector<int> first = shuffle_hypotheses(graph, seed);
    DelayedDecisionSmoother decisions;
    feed_all(graph, decisions);
    decisions.finish();
    for (std::size_t k = 0; k < first.size(); ++k) {
      EXPECT_EQ(decisions.smoother().assignment().at(hypothesis_key(k)), first[k]) << "edge " << k;
    }
    EXPECT_LT(decisions.smoother().cost(), 200.0);
  }
}

/// A long circle with eight choices before anything is recognised, and a second lap in which every
/// twentieth pose is.
PoseGraph long_laps(unsigned seed) {
  constexpr int kLap = 300;
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> far(-1.0, 1.0);
  const SE2 step(1.0, 0.0, 2 * M_PI / kLap);
  const Noise noise = Noise::isotropic(3, 0.02);
  PoseGraph graph;
  for (int i = 1; i < 2 * kLap; ++i) {
    graph.poses2.push_back({pose(i - 1), pose(i), step * random_motion<SE2>(0.02, rng), noise});
    if (i % 35 == 0 && i < kLap) {
      const double turn = i % 2 == 0 ? 0.75 : -0.75;  // several may cancel
      graph.alternatives.push_back(
          {graph.poses2.size() - 1, {step * SE2(far(rng), far(rng), turn)}});
    }
    if (i >= kLap && i % 20 == 0) {
      graph.poses2.push_back({pose(i - kLap), pose(i), random_motion<SE2>(0.02, rng), noise});
    }
  }
  return graph;
}

TEST(DelayedDecisionSmoother, ClosuresWaitUntilTheyTellTheChoicesOfALongLoopApart) {
  std::size_t waited = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    PoseGraph graph = long_laps(seed);
    const std::vector<int> first = shuffle_hypotheses(graph, seed);
    ASSERT_EQ(first.size(), 8u);
    DelayedDecisionSmoother decisions;
    waited = std::max(waited, feed_all(graph, decisions));
    for (std::size_t k = 0; k < first.size(); ++k) {
      EXPECT_EQ(decisions.smoother().assignment().at(hypothesis_key(k)), first[k]) << "edge " << k;
    }
    decisions.finish();
    EXPECT_LT(decisions.smoother().cost(), 1.5 * 2.0 * 15);
  }
  EXPECT_GT(waited, 1u);
}

TEST(DelayedDecisionSmoother, ClosuresThatDecideNothingEnterAtTheEnd) {
  // Two hypotheses that are the same: nothing can tell them apart.
  PoseGraph graph = laps(1000, 4);
  graph.alternatives.push_back({40, {graph.poses2[40].measured}});
  DelayedDecisionOptions patient;
  patient.patience = 1000;
  DelayedDecisionSmoother decisions(patient);
  EXPECT_GT(feed_all(graph, decisions), 10u);
  EXPECT_GT(decisions.waiting(), 10u);
  decisions.finish();
  EXPECT_EQ(decisions.waiting(), 0u);
  EXPECT_EQ(decisions.smoother().graph().continuous().size() + 1, graph.poses2.size() + 1);
}

TEST(DelayedDecisionSmoother, APoseThatOnlyAClosureHoldsLetsAllIn) {
  PoseGraph graph = laps(1000, 4);
  const Noise noise = Noise::isotropic(3, 0.02);
  graph.alternatives.push_back({40, {graph.poses2[40].measured}});
  graph.poses2.push_back({pose(80), pose(200), SE2(1.0, 2.0, 0.3), noise});
  DelayedDecisionOptions patient;
  patient.patience = 1000;
  DelayedDecisionSmoother decisions(patient);
  EXPECT_GT(feed_all(graph, decisions), 10u);
  EXPECT_EQ(decisions.waiting(), 0u);
}

// The other value of the choice would leave the heading of the second pose undetermined.
TEST(DelayedDecisionSmoother, AChoiceThatHoldsAPoseIsNotTakenAway) {
  DelayedDecisionSmoother decisions;
  Delta delta;
  for (int i = 0; i < 2; ++i) delta.values.insert(pose(i), SE2(i, 0, 0));
  delta.continuous = {
      std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 0.01)),
      std::make_shared<Position2>(pose(1), Eigen::Vector2d(9, 0), Noise::isotropic(2, 0.5))};
  const auto motion =
      std::make_shared<BetweenSE2>(pose(0), pose(1), SE2(1, 0, 0), Noise::isotropic(3, 0.5));
  delta.hybrid = {
      std::make_shared<Mixture>(std::vector<DiscreteKey>{{Key('h', 0), 2}},
                                std::vector<MixtureComponent>{{motion, 0.0}, {nullptr, 500.0}})};
  ASSERT_EQ(decisions.update(delta).status, UpdateReport::Status::kOk);
  const UpdateReport report = decisions.finish();
  EXPECT_EQ(report.status, UpdateReport::Status::kOk);
  EXPECT_GT(decisions.trials(), 0);
  EXPECT_EQ(decisions.smoother().assignment().at(Key('h', 0)), 0);
  EXPECT_EQ(decisions.smoother().graph().size(), 3u);
  EXPECT_NEAR(decisions.smoother().values().at<SE2>(pose(1)).translation()[0], 5.0, 1e-3);
}

TEST(DelayedDecisionSmoother, BadInputLeavesItAsItWas) {
  const PoseGraph graph = laps(11, 1);
  PoseFeed feed(graph, initialize_from_odometry(graph));
  DelayedDecisionSmoother decisions;
  Delta first = feed.next({});
  EXPECT_EQ(decisions.update(first).status, UpdateReport::Status::kOk);
  EXPECT_THROW(decisions.update(first), Error);  // the pose is there already
  EXPECT_EQ(decisions.update(feed.next(decisions.smoother().values())).status,
            UpdateReport::Status::kOk);
}

}  // namespace
}  // namespace hybrid
