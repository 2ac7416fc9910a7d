// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
// New factors that wait to be eliminated.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/marginals/continuous.h"
#include "libhybrid/smoother/incremental.h"
#include "libhybrid/smoother/transaction.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/changing_world.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::pose;
using testing::Random;
using testing::state;

/// A walk to and fro on a grid, whose places are seen again.
template <class Pose>
class GridWalk {
 public:
  explicit GridWalk(std::uint64_t seed) : random_(seed) {}

  Delta next(const IncrementalSmoother& smoother) {
    const auto k = static_cast<int>(path_.size());
    Delta delta;
    if (k == 0) {
      path_.emplace_back();
      delta.values.insert(pose(0), Pose());
      delta.continuous.push_back(
          std::make_shared<Prior<Pose>>(pose(0), Pose(), Noise::isotropic(Pose::kDim, 0.01)));
      return delta;
    }
    typename Pose::Tangent step = Pose::Tangent::Zero();
    step[0] = 1.0;
    step[Pose::kDim - 1] = k % 6 == 0 ? M_PI_2 : 0.0;
    path_.push_back(path_.back() * Pose::exp(step));
    const Pose z = measure(k - 1, k);
    delta.values.insert(pose(k), smoother.values().at<Pose>(pose(k - 1)) * z);
    delta.continuous.push_back(factor(k - 1, k, z));
    const int closures = k > 24 ? random_.below(3) : 0;
    for (int c = 0; c < closures; ++c) {
      const int old = k % 24 + 24 * random_.below(k / 24);
      delta.continuous.push_back(factor(old, k, measure(old, k)));
    }
    return delta;
  }

 private:
  Pose measure(int i, int j) {
    return path_[i].between(path_[j]) * random_.template value<Pose>(0.02);
  }
  ContinuousFactorPtr factor(int i, int j, const Pose& z) {
    return std::make_shared<Between<Pose>>(pose(i), pose(j), z, Noise::isotropic(Pose::kDim, 0.02));
  }

  Random random_;
  std::vector<Pose> path_;
};

/// What a walk comes to, while factors wait or not: costs beside their optimum, covariances beside
/// those of batch.
template <class Pose>
void expect_as_batch(double share, int& most_pending, int& eliminated) {
  for (int seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", share " + std::to_string(share));
    SmootherOptions options;
    options.defer = share;
    IncrementalSmoother smoother(options);
    GridWalk<Pose> walk(seed);
    for (int k = 0; k < 200; ++k) {
      const UpdateReport report = smoother.update(walk.next(smoother));
      ASSERT_EQ(report.status, UpdateReport::Status::kOk);
      most_pending = std::max(most_pending, report.pending);
      eliminated += report.eliminated;
      if (k % 20 != 19) continue;
      const SolverResult batch = levenberg_marquardt(smoother.graph(), smoother.estimate());
      const double optimum = cost(smoother.graph(), batch.values, smoother.assignment());
      EXPECT_LT(smoother.cost(), optimum + 0.02 * (1.0 + optimum)) << k;
      const Estimate at = smoother.estimate();
      const ContinuousMarginals marginals(smoother.graph(), at);
      for (const Key key : {pose(k), pose(k / 2)}) {
        const Eigen::MatrixXd expected = marginals.joint_covariance({key});
        EXPECT_LT((smoother.joint_covariance({key}) - expected).norm(), 0.05 * expected.norm())
            << k;
      }
      smoother.visit_covariances([&](Key key, const Eigen::MatrixXd& covariance) {
        const Eigen::MatrixXd one = smoother.joint_covariance({key});
        EXPECT_LT((covariance - one).norm(), 1e-6 * one.norm()) << to_string(key);
      });
    }
  }
}

TEST(Deferral, AMapIsAsByBatchWhetherFactorsWaitOrNot) {
  int never = 0, some = 0, eliminated_at_once = 0, eliminated_later = 0;
  expect_as_batch<SE2>(0.0, never, eliminated_at_once);
  expect_as_batch<SE2>(1.0, some, eliminated_later);
  EXPECT_EQ(never, 0);
  EXPECT_GT(some, 2);
  EXPECT_LT(eliminated_later, 0.7 * eliminated_at_once);
  expect_as_batch<SE3>(10.0, some, eliminated_later);
}

/// A pose that odometry alone ties to the last one touches nothing else.
TEST(Deferral, OdometryEliminatesOneVariable) {
  SmootherOptions options;
  options.defer = 1e9;
  IncrementalSmoother smoother(options);
  for (int k = 0; k < 50; ++k) {
    Delta delta;
    delta.values.insert(pose(k), SE2(k, 0.0, 0.0));
    delta.continuous.push_back(
        k == 0 ? std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 0.01))
               : testing::between(k - 1, k, SE2(1.0, 0.0, 0.0), 0.05));
    const UpdateReport report = smoother.update(delta);
    ASSERT_EQ(report.status, UpdateReport::Status::kOk);
    EXPECT_LE(report.eliminated, 1);
    EXPECT_EQ(report.pending, 0);
  }
}

/// What is taken back leaves no trace, whether it has waited, or what waited was eliminated.
TEST(Deferral, WhatIsTakenBackLeavesNoTrace) {
  SmootherOptions options;
  options.defer = 1.0;
  IncrementalSmoother smoother(options);
  GridWalk<SE2> walk(7);
  int with_pending = 0;
  for (int k = 0; k < 150; ++k) {
    smoother.update(walk.next(smoother));
    if (k < 60) continue;
    const std::vector<double> before = state(smoother);
    {
      const Transaction transaction(smoother);
      Delta closure;
      closure.continuous.push_back(testing::between(k - 50, k, SE2(3.0, 1.0, 0.2), 0.1));
      const UpdateReport report = smoother.update(closure);
      with_pending += report.pending > 0 ? 1 : 0;
      if (k % 3 == 0) smoother.settle();
      if (k % 5 == 0) smoother.converge();
    }
    ASSERT_EQ(state(smoother), before) << k;
  }
  EXPECT_GT(with_pending, 20);
}

}  // namespace
}  // namespace hybrid
