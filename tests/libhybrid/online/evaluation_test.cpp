// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// Evaluations of all closures that are spread over the updates of the online selection.
#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "libhybrid/core/infinity.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/online/online_selection.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::pose;
using testing::random_motion;

constexpr int kLap = 40;
constexpr int kPoses = 4 * kLap;
constexpr int kLandmark = 1000;
constexpr double kSigma = 0.01;

/// A robot on a circle with a true closure to the lap before at each pose. Those of the first five
/// are shifted, each by the same: they agree with each other and with the odometry.
class RoundAndRound {
 public:
  RoundAndRound() : truth_(kPoses), odometry_(kPoses) {
    std::mt19937 rng(1);
    const SE2 motion = testing::step_forward<SE2>(2 * M_PI / kLap);
    for (int i = 1; i < kPoses; ++i) {
      truth_[i] = truth_[i - 1] * motion;
      odometry_[i] = motion * random_motion<SE2>(kSigma, rng);
    }
    for (int i = kLap; i < kPoses; ++i) {
      const SE2 error = is_true(i) ? random_motion<SE2>(kSigma, rng) : SE2(0.0, 80 * kSigma, 0.0);
      closures_.push_back(between(i - kLap, i, truth_[i - kLap].between(truth_[i]) * error));
    }
  }

  static bool is_true(int i) { return i >= kLap + 5; }
  const SE2& odometry(int i) const { return odometry_[i]; }

  SelectionReport add(int i, OnlineSelection& selection) const {
    Delta delta;
    if (i == 0) {
      delta.values.insert(pose(0), SE2());
      delta.continuous.push_back(
          std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 1e-3)));
    } else {
      delta.values.insert(pose(i),
                          selection.smoother().values().at<SE2>(pose(i - 1)) * odometry_[i]);
      delta.continuous.push_back(between(i - 1, i, odometry_[i]));
    }
    if (i < kLap) return selection.update(delta);
    return selection.update(delta, {closures_[i - kLap]});
  }

  /// How far the estimate is from the odometry at most [m].
  double worst_step(const Values& values, int poses) const {
    double worst = 0.0;
    for (int i = 1; i < poses; ++i) {
      const SE2 step = values.at<SE2>(pose(i - 1)).between(values.at<SE2>(pose(i)));
      worst = std::max(worst, odometry_[i].between(step).translation().norm());
    }
    return worst;
  }

 private:
  static ContinuousFactorPtr between(int i, int j, const SE2& measured) {
    return std::make_shared<BetweenSE2>(pose(i), pose(j), measured, Noise::isotropic(3, kSigma));
  }

  std::vector<SE2> truth_, odometry_;
  std::vector<ContinuousFactorPtr> closures_;
};

OnlineSelection with_spread(double spread) {
  OnlineSelectionOptions options;
  options.spread = spread;
  return OnlineSelection(options);
}

void expect_right(const OnlineSelection& selection) {
  const std::vector<ClosureDecision> decisions = selection.decisions();
  for (int i = kLap; i < kPoses; ++i) {
    const auto k = static_cast<std::size_t>(i - kLap);
    EXPECT_EQ(selection.status(k) == ClosureStatus::kAccepted, RoundAndRound::is_true(i)) << k;
    EXPECT_EQ(decisions[k].accepted(), RoundAndRound::is_true(i)) << k;
  }
}

TEST(Evaluation, EndsLaterAndComesToTheSame) {
  const RoundAndRound world;
  OnlineSelection at_once = with_spread(kInfinity), spread = with_spread(3.0);
  int under_way = 0;
  for (int i = 0; i < kPoses; ++i) {
    ASSERT_EQ(world.add(i, at_once).status, UpdateReport::Status::kOk);
    ASSERT_EQ(world.add(i, spread).status, UpdateReport::Status::kOk);
    EXPECT_FALSE(at_once.evaluating());
    under_way += spread.evaluating() ? 1 : 0;
    // What has come since an evaluation began moves along when it is adopted.
    EXPECT_LT(world.worst_step(spread.smoother().values(), i + 1), 10 * kSigma) << i;
  }
  EXPECT_GT(under_way, 5);
  EXPECT_FALSE(spread.evaluating());
  expect_right(spread);  // of those that came while it was under way, too
  at_once.finish();
  spread.finish();
  expect_right(spread);
  EXPECT_LT(testing::distance(spread.smoother().values(), at_once.smoother().values()), 1e-4);
  EXPECT_NEAR(spread.smoother().objective(), at_once.smoother().objective(), 1e-6);
}

TEST(Evaluation, IsDroppedByFinish) {
  const RoundAndRound world;
  OnlineSelection selection = with_spread(1e-3);
  for (int i = 0; i < kPoses; ++i) world.add(i, selection);
  EXPECT_TRUE(selection.evaluating());
  selection.finish();
  EXPECT_FALSE(selection.evaluating());
  expect_right(selection);
}

TEST(Evaluation, GoesOnAfterAnUpdateThatIsRefused) {
  const RoundAndRound world;
  OnlineSelection selection = with_spread(3.0), refused = with_spread(3.0);
  int refusals = 0;
  for (int i = 0; i < kPoses; ++i) {
    if (refused.evaluating()) {
      Delta delta;
      delta.values.insert(pose(kLandmark), SE2());
      EXPECT_EQ(refused.update(delta).status, UpdateReport::Status::kSingular);
      ++refusals;
    }
    world.add(i, selection);
    world.add(i, refused);
    ASSERT_EQ(refused.evaluating(), selection.evaluating()) << i;
  }
  EXPECT_GT(refusals, 5);
  expect_right(refused);
  EXPECT_LT(testing::distance(refused.smoother().values(), selection.smoother().values()), 1e-9);
}

TEST(Evaluation, OfACopyBeginsAnew) {
  const RoundAndRound world;
  OnlineSelection selection = with_spread(3.0);
  int i = 0;
  while (!selection.evaluating()) world.add(i++, selection);
  world.add(i++, selection);
  OnlineSelection copy = selection;
  EXPECT_TRUE(selection.evaluating());
  EXPECT_FALSE(copy.evaluating());
  for (; i < kPoses; ++i) {
    world.add(i, selection);
    world.add(i, copy);
  }
  expect_right(selection);
  expect_right(copy);
}

}  // namespace
}  // namespace hybrid
