// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/choices/detail/choice_comparison.h"

#include <gtest/gtest.h>

#include <memory>

#include "libhybrid/choices/detail/segment_transforms.h"
#include "libhybrid/pose_graph/pose_feed.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::pose;
using testing::random_motion;

/// Twenty steps of which two have a second hypothesis, and a closure inside the last piece.
PoseGraph path() {
  std::mt19937 rng(1);
  const Noise noise = Noise::isotropic(3, 0.05);
  PoseGraph graph;
  for (int i = 1; i <= 20; ++i) {
    const SE2 z = SE2(1.0, 0.0, 0.3) * random_motion<SE2>(0.05, rng);
    graph.poses2.push_back({pose(i - 1), pose(i), z, noise});
    if (i == 5 || i == 12)
      graph.alternatives2.push_back({graph.poses2.size() - 1, {z * SE2(1, 1, 1)}});
  }
  const SE2 back = SE2(1.0, 0.0, 0.3) * SE2(1.0, 0.0, 0.3) * SE2(1.0, 0.0, 0.3);
  graph.poses2.push_back({pose(14), pose(17), back, noise});
  return graph;
}

TEST(ChoiceComparison, CostsAreThoseOfTheWholeGraph) {
  const PoseGraph graph = path();
  IncrementalSmoother smoother;
  PoseFeed feed(graph, initialize_from_odometry(graph));
  std::vector<HybridFactorPtr> choices;
  HybridGraph whole;
  while (!feed.done()) {
    const Delta delta = feed.next(smoother.values());
    for (const auto& factor : delta.hybrid) whole.add(factor);
    for (const auto& factor : delta.continuous) whole.add(factor);
    choices.insert(choices.end(), delta.hybrid.begin(), delta.hybrid.end());
    smoother.update(delta);
  }
  smoother.converge();
  const Noise noise = Noise::isotropic(3, 0.05);
  std::vector<ContinuousFactorPtr> closures;
  for (const auto& [a, b] : {std::pair(3, 18), std::pair(2, 15), std::pair(8, 20)}) {
    const SE2 z = smoother.values().at<SE2>(pose(a)).between(smoother.values().at<SE2>(pose(b))) *
                  SE2(0.1, -0.1, 0.05);
    closures.push_back(std::make_shared<BetweenSE2>(pose(a), pose(b), z, noise));
    whole.add(closures.back());
  }
  const ChoiceComparison<SE2> comparison(smoother, choices, closures, {}, {}, 10.0);
  const auto cost_of_whole = [&](const std::vector<int>& values) {
    Estimate start{smoother.values(), {}};
    SegmentTransforms<SE2> swings;
    for (std::size_t c : {0, 1}) {
      start.assignment.set(choices[c]->discrete_keys()[0].key, values[c]);
      swings.add(*choices[c], values[c], smoother.values());
    }
    for (Key key : start.values.keys()) {
      start.values.update(key, swings(key, start.values.at<SE2>(key)));
    }
    return objective(whole, levenberg_marquardt(whole, start).values, start.assignment);
  };
  // The two objectives differ by the constants of factors, and by the closure inside the last
  // piece.
  const double whole_offset = cost_of_whole({0, 0}), offset = comparison.fit({0, 0}).cost;
  for (const std::vector<int>& values : {std::vector<int>{1, 0}, {0, 1}, {1, 1}}) {
    const double more = comparison.fit(values).cost - offset;
    EXPECT_GT(more, 10.0);
    EXPECT_NEAR(cost_of_whole(values) - whole_offset, more, 0.05 * more);
  }
}

TEST(SegmentTransforms, MoveWhatHangsOnAChoice) {
  const PoseGraph graph = path();
  const HybridFactorPtr choice = make_hypotheses(graph, 1);
  const Values values = initialize_from_odometry(graph);
  SegmentTransforms<SE2> swings;
  swings.add(*choice, 1, values);
  const SE2 before = values.at<SE2>(pose(11));
  EXPECT_EQ(swings(pose(11), before).x(), before.x());
  const SE2 behind = swings(pose(12), values.at<SE2>(pose(12)));
  EXPECT_LT((before.between(behind).inverse() * motion_of<SE2>(*choice, 1)).log().norm(), 1e-12);
  const SE2 step = values.at<SE2>(pose(12)).between(values.at<SE2>(pose(16)));
  const SE2 moved = behind.between(swings(pose(16), values.at<SE2>(pose(16))));
  EXPECT_LT((step.inverse() * moved).log().norm(), 1e-12);
}

}  // namespace
}  // namespace hybrid
