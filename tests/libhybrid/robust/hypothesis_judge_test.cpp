// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/robust/hypothesis_judge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "libhybrid/io/pose_feed.h"
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

TEST(HypothesisJudge, FindsTheTrueHypothesesOnline) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    PoseGraph graph = laps(11, seed);
    const std::vector<int> first = shuffle_hypotheses(graph, seed);
    HypothesisJudge judge;
    PoseFeed feed(graph, initialize_from_odometry(graph));
    while (!feed.done()) {
      const UpdateReport report = judge.update(feed.next(judge.smoother().values()));
      ASSERT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
    }
    judge.finish();
    for (std::size_t k = 0; k < first.size(); ++k) {
      EXPECT_EQ(judge.smoother().assignment().at(hypothesis_key(k)), first[k]) << "edge " << k;
    }
    EXPECT_LT(judge.smoother().cost(), 200.0);
  }
}

TEST(HypothesisJudge, BadInputLeavesItAsItWas) {
  const PoseGraph graph = laps(11, 1);
  PoseFeed feed(graph, initialize_from_odometry(graph));
  HypothesisJudge judge;
  Delta first = feed.next({});
  EXPECT_EQ(judge.update(first).status, UpdateReport::Status::kOk);
  EXPECT_THROW(judge.update(first), Error);  // the pose is there already
  EXPECT_EQ(judge.update(feed.next(judge.smoother().values())).status, UpdateReport::Status::kOk);
}

}  // namespace
}  // namespace hybrid
