// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>
#include <type_traits>
#include <utility>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/position.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/online/online_selection.h"
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
      graph.alternatives2.push_back(
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
std::size_t feed_all(const PoseGraph& graph, OnlineSelection& decisions) {
  std::size_t waited = 0;
  PoseFeed feed(graph, initialize_from_odometry(graph));
  while (!feed.done()) {
    const UpdateReport report = decisions.update(feed.next(decisions.smoother().values()));
    EXPECT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
    waited = std::max(waited, decisions.waiting());
  }
  return waited;
}

TEST(OnlineChoices, FindsTheTrueHypothesesOnline) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    PoseGraph graph = laps(11, seed);
    const std::vector<int> first = shuffle_hypotheses(graph, seed);
    OnlineSelection decisions;
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
      graph.alternatives2.push_back(
          {graph.poses2.size() - 1, {step * SE2(far(rng), far(rng), turn)}});
    }
    if (i >= kLap && i % 20 == 0) {
      graph.poses2.push_back({pose(i - kLap), pose(i), random_motion<SE2>(0.02, rng), noise});
    }
  }
  return graph;
}

TEST(OnlineChoices, ClosuresWaitUntilTheyTellTheChoicesOfALongLoopApart) {
  std::size_t waited = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    PoseGraph graph = long_laps(seed);
    const std::vector<int> first = shuffle_hypotheses(graph, seed);
    ASSERT_EQ(first.size(), 8u);
    OnlineSelection decisions;
    waited = std::max(waited, feed_all(graph, decisions));
    for (std::size_t k = 0; k < first.size(); ++k) {
      EXPECT_EQ(decisions.smoother().assignment().at(hypothesis_key(k)), first[k]) << "edge " << k;
    }
    decisions.finish();
    EXPECT_LT(decisions.smoother().cost(), 1.5 * 2.0 * 15);
  }
  EXPECT_GT(waited, 1u);
}

TEST(OnlineChoices, ClosuresThatDecideNothingEnterAtTheEnd) {
  // Two hypotheses that are the same: nothing can tell them apart.
  PoseGraph graph = laps(1000, 4);
  graph.alternatives2.push_back({40, {graph.poses2[40].measured}});
  OnlineSelectionOptions patient;
  patient.patience = 1000;
  OnlineSelection decisions(patient);
  EXPECT_GT(feed_all(graph, decisions), 10u);
  EXPECT_GT(decisions.waiting(), 10u);
  decisions.finish();
  EXPECT_EQ(decisions.waiting(), 0u);
  EXPECT_EQ(decisions.smoother().graph().continuous().size() + 1, graph.poses2.size() + 1);
}

TEST(OnlineChoices, APoseThatOnlyAClosureHoldsLetsAllIn) {
  PoseGraph graph = laps(1000, 4);
  const Noise noise = Noise::isotropic(3, 0.02);
  graph.alternatives2.push_back({40, {graph.poses2[40].measured}});
  graph.poses2.push_back({pose(80), pose(200), SE2(1.0, 2.0, 0.3), noise});
  OnlineSelectionOptions patient;
  patient.patience = 1000;
  OnlineSelection decisions(patient);
  EXPECT_GT(feed_all(graph, decisions), 10u);
  EXPECT_EQ(decisions.waiting(), 0u);
}

// The other value of the choice would leave the heading of the second pose undetermined.
TEST(OnlineChoices, AChoiceThatHoldsAPoseIsNotTakenAway) {
  OnlineSelection decisions;
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

template <class Pose>
std::vector<GraphEdge<Pose>>& edges(PoseGraph& graph) {
  if constexpr (std::is_same_v<Pose, SE2>) {
    return graph.poses2;
  } else {
    return graph.poses3;
  }
}

template <class Pose>
std::vector<EdgeAlternatives<Pose>>& alternatives(PoseGraph& graph) {
  if constexpr (std::is_same_v<Pose, SE2>) {
    return graph.alternatives2;
  } else {
    return graph.alternatives3;
  }
}

/// Three laps, every seventh step with a second hypothesis, every pose recognised a lap later; of
/// four closures that are tried one is false.
template <class Pose>
struct UncertainLaps {
  explicit UncertainLaps(unsigned seed) {
    constexpr int kLap = 30;
    std::mt19937 rng(seed);
    const Noise noise = Noise::isotropic(Pose::kDim, 0.02);
    const Pose step = testing::step_forward<Pose>(2 * M_PI / kLap);
    std::vector<Pose> truth(1);
    std::vector<GraphEdge<Pose>>& all = edges<Pose>(graph);
    for (int i = 1; i < 3 * kLap; ++i) {
      truth.push_back(truth.back() * step);
      all.push_back({pose(i - 1), pose(i), step * random_motion<Pose>(0.01, rng), noise});
      if (i % 7 == 0) {
        alternatives<Pose>(graph).push_back({all.size() - 1, {step * random_motion<Pose>(1, rng)}});
      }
      if (i < kLap) continue;
      const Pose z = truth[i - kLap].between(truth[i]) * random_motion<Pose>(0.01, rng);
      all.push_back({pose(i - kLap), pose(i), z, noise});
      if (i % 3 != 0) continue;
      all.push_back({pose(i - kLap + 3), pose(i), random_motion<Pose>(2, rng), noise});
      lies.insert({i - kLap + 3, i});
    }
    first = shuffle_hypotheses(graph, seed);
  }

  PoseGraph graph;
  std::set<std::pair<std::uint64_t, std::uint64_t>> lies;
  std::vector<int> first;
};

template <class Pose>
class OnlineChoicesOf : public ::testing::Test {};
using Poses = ::testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(OnlineChoicesOf, Poses);

TYPED_TEST(OnlineChoicesOf, AreDecidedAmongFalseClosures) {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    const UncertainLaps<TypeParam> laps(seed);
    OnlineSelection selection;
    PoseFeed feed(laps.graph, initialize_from_odometry(laps.graph));
    std::vector<bool> lies;
    while (!feed.done()) {
      Delta delta = feed.next(selection.smoother().values());
      std::vector<ContinuousFactorPtr> trusted, closures;
      for (const ContinuousFactorPtr& factor : delta.continuous) {
        const std::vector<Key>& keys = factor->keys();
        const bool closure = keys.size() == 2 && !is_odometry(keys[0], keys[1]);
        (closure ? closures : trusted).push_back(factor);
        if (closure) lies.push_back(laps.lies.count({keys[0].index(), keys[1].index()}) != 0);
      }
      delta.continuous = trusted;
      ASSERT_EQ(selection.update(delta, closures).status, UpdateReport::Status::kOk);
    }
    ASSERT_EQ(selection.finish().status, UpdateReport::Status::kOk);
    for (std::size_t k = 0; k < laps.first.size(); ++k) {
      EXPECT_EQ(selection.smoother().assignment().at(hypothesis_key(k)), laps.first[k])
          << "edge " << k << ", seed " << seed;
    }
    EXPECT_EQ(selection.waiting(), 0u);
    ASSERT_EQ(lies.size(), 80u);
    for (std::size_t k = 0; k < lies.size(); ++k) {
      EXPECT_EQ(selection.status(k) == ClosureStatus::kAccepted, !lies[k])
          << "closure " << k << ", seed " << seed;
    }
  }
}

// Two hypotheses that are the same: nothing can tell them apart.
TEST(OnlineChoices, AClosureThatWaitsIsUndecidedAndOneThatNothingExplainsIsRejected) {
  const Noise noise = Noise::isotropic(3, 0.02);
  const auto step = [&](int i) {
    return std::make_shared<BetweenSE2>(pose(i), pose(i + 1), SE2(1, 0, 0), noise);
  };
  const auto closure = [&](const SE2& z) {
    return std::make_shared<BetweenSE2>(pose(0), pose(3), z, noise);
  };
  OnlineSelection selection;
  Delta delta;
  for (int i = 0; i < 4; ++i) delta.values.insert(pose(i), SE2(i, 0, 0));
  delta.continuous = {std::make_shared<Prior<SE2>>(pose(0), SE2(), noise), step(0), step(2)};
  delta.hybrid = {
      std::make_shared<Mixture>(std::vector<DiscreteKey>{{Key('h', 0), 2}},
                                std::vector<MixtureComponent>{{step(1), 0.0}, {step(1), 0.0}})};
  ASSERT_EQ(selection.update(delta, {closure(SE2(3, 0, 0)), closure(SE2(3, 9, 0))}).status,
            UpdateReport::Status::kOk);
  EXPECT_EQ(selection.waiting(), 1u);
  EXPECT_EQ(selection.status(0), ClosureStatus::kUndecided);
  EXPECT_EQ(selection.status(1), ClosureStatus::kRejected);
  ASSERT_EQ(selection.finish().status, UpdateReport::Status::kOk);
  EXPECT_EQ(selection.waiting(), 0u);
  EXPECT_EQ(selection.status(0), ClosureStatus::kAccepted);
  EXPECT_EQ(selection.status(1), ClosureStatus::kRejected);
}

/// A straight way with one choice, and the same way back.
TEST(OnlineChoices, ADecisionByAFalseClosureIsReversed) {
  const Noise noise = Noise::isotropic(3, 0.02);
  const auto between = [&](int i, int j, const SE2& z) {
    return std::make_shared<BetweenSE2>(pose(i), pose(j), z, noise);
  };
  const SE2 step(1, 0, 0), wrong(1, 0.7, 0.5);
  OnlineSelection selection;
  for (int i = 0; i < 30; ++i) {
    Delta delta;
    delta.values.insert(pose(i), SE2(i, 0, 0));
    std::vector<ContinuousFactorPtr> closures;
    if (i == 0) {
      delta.continuous = {std::make_shared<Prior<SE2>>(pose(0), SE2(), noise)};
    } else if (i == 5) {
      delta.hybrid = {std::make_shared<Mixture>(
          std::vector<DiscreteKey>{{Key('h', 0), 2}},
          std::vector<MixtureComponent>{{between(4, 5, step), 0.0, false},
                                        {between(4, 5, wrong), 0.0, false}})};
    } else {
      delta.continuous = {between(i - 1, i, step)};
    }
    if (i == 6 || i == 7) closures = {between(4, i, wrong * SE2(i - 5, 0, 0))};
    if (i > 12) closures = {between(i - 12, i, SE2(12, 0, 0))};
    ASSERT_EQ(selection.update(delta, closures).status, UpdateReport::Status::kOk);
    if (i == 8) {
      EXPECT_EQ(selection.smoother().assignment().at(Key('h', 0)), 1);
    }
  }
  ASSERT_EQ(selection.finish().status, UpdateReport::Status::kOk);
  EXPECT_EQ(selection.smoother().assignment().at(Key('h', 0)), 0);
  for (std::size_t k = 0; k < 19; ++k) {
    EXPECT_EQ(selection.status(k) == ClosureStatus::kAccepted, k > 1) << "closure " << k;
  }
  EXPECT_LT(selection.smoother().values().at<SE2>(pose(29)).between(SE2(29, 0, 0)).log().norm(),
            0.1);
}

TEST(OnlineChoices, BadInputLeavesItAsItWas) {
  const PoseGraph graph = laps(11, 1);
  PoseFeed feed(graph, initialize_from_odometry(graph));
  OnlineSelection decisions;
  Delta first = feed.next({});
  EXPECT_EQ(decisions.update(first).status, UpdateReport::Status::kOk);
  EXPECT_THROW(decisions.update(first), Error);  // the pose is there already
  EXPECT_EQ(decisions.update(feed.next(decisions.smoother().values())).status,
            UpdateReport::Status::kOk);
}

}  // namespace
}  // namespace hybrid
