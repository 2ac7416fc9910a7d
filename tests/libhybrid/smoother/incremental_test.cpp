// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/incremental.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <random>
#include <vector>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/mixture.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/dense_graph.h"
#include "tests/support/hard_factors.h"

namespace hybrid {
namespace {

Key pose(int i) {
  return {'x', static_cast<std::uint64_t>(i)};
}

Delta first_pose() {
  Delta delta;
  delta.values.insert(pose(0), SE2());
  delta.continuous.push_back(
      std::make_shared<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 0.01)));
  return delta;
}

ContinuousFactorPtr between(int i, int j, const SE2& z, double sigma) {
  return std::make_shared<BetweenSE2>(pose(i), pose(j), z, Noise::isotropic(3, sigma));
}

/// A loop closure that may be a lie (eq. 17).
HybridFactorPtr closure(int number, int i, int j, const SE2& z) {
  return make_outlier_mixture({{'d', static_cast<std::uint64_t>(number)}, 2},
                              between(i, j, z, 0.05), between(i, j, z, 0.05 * std::sqrt(1e7)), 0.5,
                              0.5);
}

/// Its loss is far from half a squared residual there, but its linear model is as good as any.
TEST(IncrementalSmoother, AFactorFarOutInItsRobustLossIsNotLinearisedAgainForNothing) {
  IncrementalSmoother smoother;
  Delta first = first_pose();
  first.continuous.push_back(std::make_shared<Prior<SE2>>(pose(0), SE2(5.0, 0.0, 0.0),
                                                          Noise::isotropic(3, 0.1), Loss::huber()));
  smoother.update(first);
  smoother.converge();
  int again = 0;
  for (int k = 1; k <= 20; ++k) {
    Delta delta;
    const SE2 motion(1.0, 0.0, 0.0);
    delta.values.insert(pose(k), smoother.values().at<SE2>(pose(k - 1)) * motion);
    delta.continuous.push_back(between(k - 1, k, motion, 0.05));
    delta.continuous.push_back(between(0, k, SE2(k + 0.001 * (k % 3 - 1), 0.0, 0.0), 0.05));
    const UpdateReport report = smoother.update(delta);
    EXPECT_EQ(report.rounds, 1);
    again += report.relinearized;
  }
  EXPECT_EQ(again, 0);
}

/// By how much the objective falls when the smoother converges after a loop of forty poses has
/// closed whose odometry turns too far.
double left_after_a_loop(int rounds, double& open) {
  SmootherOptions options;
  options.rounds = rounds;
  IncrementalSmoother smoother(options);
  smoother.update(first_pose());
  SE2 truth;
  for (int k = 1; k <= 40; ++k) {
    const SE2 motion(1.0, 0.0, 2.0 * M_PI / 40.0);
    truth = truth * motion;
    const SE2 measured(1.0, 0.0, motion.angle() + 0.02);
    Delta delta;
    delta.values.insert(pose(k), smoother.values().at<SE2>(pose(k - 1)) * measured);
    delta.continuous.push_back(between(k - 1, k, measured, 0.05));
    if (k == 40) delta.continuous.push_back(between(0, k, truth, 0.01));
    const UpdateReport report = smoother.update(delta);
    EXPECT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
    EXPECT_LE(report.rounds, k < 40 ? 1 : rounds);
    open = report.open;
  }
  const double after = smoother.objective();
  smoother.converge();
  return after - smoother.objective();
}

/// The estimate after the update is that of the whole problem, not that of one linear model; what
/// is left is reported.
TEST(IncrementalSmoother, AnUpdateGoesOnAfterALargeInnovation) {
  double open = 0.0;
  EXPECT_LT(left_after_a_loop(10, open), 1.0);
  EXPECT_LT(open, 1.0);
  EXPECT_LT(left_after_a_loop(3, open), 1.0);
  EXPECT_GT(left_after_a_loop(1, open), 10.0);
  EXPECT_GT(open, 10.0);
}

TEST(IncrementalSmoother, EqualsBatchOnRandomGraphsThatGrowAndShrink) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0.0, 0.03);
    IncrementalSmoother smoother;
    ASSERT_EQ(smoother.update(first_pose()).status, UpdateReport::Status::kOk);
    std::vector<SE2> truth = {SE2()};
    std::vector<Handle> closures;
    for (int k = 1; k < 40; ++k) {
      const SE2 motion(1.0, 0.0, 0.4);
      truth.push_back(truth.back() * motion);
      Delta delta;
      const SE2 measured = motion * SE2::exp({noise(random), noise(random), noise(random)});
      delta.values.insert(pose(k), smoother.values().at<SE2>(pose(k - 1)) * measured);
      delta.continuous.push_back(between(k - 1, k, measured, 0.03));
      if (k > 4 && random() % 2 == 0) {
        const int old = static_cast<int>(random() % (k - 2));
        SE2 z = truth[old].inverse() * truth[k] *
                SE2::exp({noise(random), noise(random), noise(random)});
        if (random() % 3 == 0) z = z * SE2(3.0, -2.0, 1.0);
        delta.hybrid.push_back(closure(k, old, k, z));
      }
      if (!closures.empty() && random() % 4 == 0) {
        const std::size_t at = random() % closures.size();
        delta.remove.push_back(closures[at]);
        closures.erase(closures.begin() + at);
      }
      const UpdateReport report = smoother.update(delta);
      ASSERT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
      const std::vector<Handle>& added = report.handles.hybrid;
      closures.insert(closures.end(), added.begin(), added.end());
      for (std::size_t i = 1; i < report.objectives.size(); ++i) {
        EXPECT_LE(report.objectives[i], report.objectives[i - 1] + 1e-9);
      }
      EXPECT_NEAR(smoother.objective(),
                  objective(smoother.graph(), smoother.values(), smoother.assignment()), 1e-7);
    }
    smoother.converge(100, 1e-15);  // linearised where the estimate is
    SolverOptions options;
    options.relative_decrease = 1e-14;
    const SolverResult batch = levenberg_marquardt(smoother.graph(), smoother.estimate(), options);
    for (int k = 0; k < 40; ++k) {
      const SE2 difference =
          batch.values.at<SE2>(pose(k)).inverse() * smoother.values().at<SE2>(pose(k));
      EXPECT_LT(difference.log().norm(), 1e-5) << pose(k);
    }
    std::vector<Key> keys = smoother.values().keys();
    const Eigen::MatrixXd dense =
        testing::dense_information(smoother.graph(), smoother.estimate()).inverse();
    EXPECT_LT((smoother.joint_covariance(keys) - dense).cwiseAbs().maxCoeff(),
              2e-5 * dense.cwiseAbs().maxCoeff());
    smoother.visit_covariances([&](Key key, const Eigen::MatrixXd& covariance) {
      const auto at = 3 * (std::find(keys.begin(), keys.end(), key) - keys.begin());
      EXPECT_LT((covariance - dense.block(at, at, 3, 3)).cwiseAbs().maxCoeff(),
                2e-5 * dense.cwiseAbs().maxCoeff());
    });
  }
}

TEST(IncrementalSmoother, NamesWhatIsUnderConstrainedAndStaysAsItWas) {
  IncrementalSmoother smoother;
  smoother.update(first_pose());
  Delta delta;
  delta.values.insert(pose(1), SE2(1.0, 0.0, 0.0));
  delta.values.insert(pose(7), SE2());
  delta.continuous.push_back(between(0, 1, SE2(1.0, 0.0, 0.0), 0.1));
  const double before = smoother.objective();
  const UpdateReport report = smoother.update(delta);
  EXPECT_EQ(report.status, UpdateReport::Status::kSingular);
  EXPECT_EQ(report.under_constrained, pose(7));
  EXPECT_TRUE(report.handles.empty());
  EXPECT_EQ(smoother.values().size(), 1u);
  EXPECT_EQ(smoother.graph().size(), 1u);
  EXPECT_DOUBLE_EQ(smoother.objective(), before);

  Delta good;
  good.values.insert(pose(1), SE2(1.0, 0.1, 0.0));
  good.continuous.push_back(between(0, 1, SE2(1.0, 0.0, 0.0), 0.1));
  EXPECT_EQ(smoother.update(good).status, UpdateReport::Status::kOk);
  EXPECT_NEAR(smoother.values().at<SE2>(pose(1)).y(), 0.0, 1e-6);
}

TEST(IncrementalSmoother, RefusesBadInputAndStaysAsItWas) {
  IncrementalSmoother smoother;
  const UpdateReport first = smoother.update(first_pose());
  Delta duplicate = first_pose();
  EXPECT_THROW(smoother.update(duplicate), Error);
  Delta unknown;
  unknown.continuous.push_back(between(0, 5, SE2(), 0.1));
  EXPECT_THROW(smoother.update(unknown), Error);
  Delta nan;
  nan.values.insert(pose(1), SE2());
  nan.continuous.push_back(std::make_shared<testing::UndefinedMotion>(pose(0), pose(1)));
  EXPECT_THROW(smoother.update(nan), Error);
  Delta held;
  held.remove_values.push_back(pose(0));
  EXPECT_THROW(smoother.update(held), Error);
  Delta gone;
  gone.remove.push_back(first.handles.continuous[0]);
  gone.remove.push_back(first.handles.continuous[0]);
  EXPECT_THROW(smoother.update(gone), Error);
  EXPECT_EQ(smoother.graph().size(), 1u);
  EXPECT_EQ(smoother.values().size(), 1u);
}

}  // namespace
}  // namespace hybrid
