// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/continuous.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/range.h"
#include "tests/support/dense_graph.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::dense_information;
using testing::pose;

void expect_covariances_of_dense_inverse(const HybridGraph& graph, const Estimate& estimate,
                                         double tolerance) {
  const Eigen::MatrixXd sigma = dense_information(graph, estimate).inverse();
  const ContinuousMarginals marginals(graph, estimate);
  ASSERT_TRUE(marginals.valid());
  const Covariances all = marginals.all();
  EXPECT_EQ(all.size(), estimate.values.size());
  int start = 0;
  for (Key key : estimate.values.keys()) {
    const int dim = estimate.values.type(key).dim;
    const Eigen::MatrixXd expected = sigma.block(start, start, dim, dim);
    const double scale = expected.cwiseAbs().maxCoeff();
    EXPECT_LT((all.at(key) - expected).cwiseAbs().maxCoeff(), tolerance * scale) << key;
    EXPECT_LT((marginals.covariance(key) - expected).cwiseAbs().maxCoeff(), tolerance * scale);
    start += dim;
  }
}

TEST(ContinuousMarginals, EqualTheDenseInverseInThePlane) {
  const auto s = testing::simulate_loops<SE2, BetweenSE2>(120, 150, 0.05, 1);
  expect_covariances_of_dense_inverse(s.graph, s.initial, 1e-9);
}

TEST(ContinuousMarginals, EqualTheDenseInverseInSpaceWithLandmarks) {
  auto s = testing::simulate_loops<SE3>(60, 40, 0.05, 2);
  for (int i = 0; i < 20; ++i) {
    s.initial.values.insert(Key('l', i), Eigen::Vector3d(i, 1.0, 0.5 * i));
    for (int j = 0; j < 3; ++j) {
      s.graph.emplace<BearingRange3>(pose(i * 3 + j % 2), Key('l', i), Eigen::Vector3d(3, 0.1, 0.2),
                                     Noise::isotropic(3, 0.1 + 0.1 * j));
    }
  }
  expect_covariances_of_dense_inverse(s.graph, s.initial, 1e-9);
}

TEST(ContinuousMarginals, CountWeakComponents) {
  const auto s = testing::simulate_outliers(20, 10, 0.3, false, 3);
  expect_covariances_of_dense_inverse(s.graph, s.initial, 1e-9);
}

TEST(ContinuousMarginals, AreTheSameForAnyNumberOfThreadsOnALargeGraph) {
  const auto s = testing::simulate_loops<SE2, BetweenSE2>(1500, 700, 0.05, 4);
  MarginalOptions one, two;
  one.threads = 1;
  two.threads = 2;
  const ContinuousMarginals a(s.graph, s.initial, one);
  const ContinuousMarginals b(s.graph, s.initial, two);
  const Covariances all_a = a.all();
  const Covariances all_b = b.all();
  for (int i = 0; i < 1500; ++i) EXPECT_EQ(all_a.at(pose(i)), all_b.at(pose(i)));
  for (int i = 0; i < 1500; i += 100) {
    const Eigen::MatrixXd exact = a.covariance(pose(i));
    EXPECT_LT((all_a.at(pose(i)) - exact).norm(), 1e-9 * exact.norm());
  }
}

TEST(ContinuousMarginals, JointOfAFewIsTheBlockOfTheDenseInverse) {
  const auto s = testing::simulate_loops<SE2, BetweenSE2>(50, 30, 0.05, 5);
  const Eigen::MatrixXd sigma = dense_information(s.graph, s.initial).inverse();
  const std::vector<Key> keys = {pose(40), pose(3), pose(17)};
  const Eigen::MatrixXd joint = ContinuousMarginals(s.graph, s.initial).joint_covariance(keys);
  for (int a = 0; a < 3; ++a) {
    for (int b = 0; b < 3; ++b) {
      const Eigen::Matrix3d expected = sigma.block<3, 3>(3 * keys[a].index(), 3 * keys[b].index());
      EXPECT_LT((joint.block<3, 3>(3 * a, 3 * b) - expected).norm(), 1e-9 * sigma.norm());
    }
  }
}

TEST(ContinuousMarginals, NameWhatIsUnderConstrained) {
  auto s = testing::simulate_loops<SE2, BetweenSE2>(8, 4, 0.05, 6);
  s.graph.remove(s.graph.continuous().handle(0));
  const ContinuousMarginals marginals(s.graph, s.initial);
  EXPECT_FALSE(marginals.valid());
  EXPECT_EQ(marginals.under_constrained().size(), 8u);
  EXPECT_THROW(marginals.covariance(pose(1)), Error);
}

TEST(ContinuousMarginals, OfWhatIsDeterminedDoNotMindWhatIsNot) {
  for (double angle : {0.0, 0.5, M_PI / 2, 2.5}) {  // a point in any direction of its one range
    auto s = testing::simulate_loops<SE2, BetweenSE2>(30, 20, 0.05, 8);
    const Covariances before = ContinuousMarginals(s.graph, s.initial).all();
    const SE2 at = s.initial.values.at<SE2>(pose(9));
    s.initial.values.insert(
        Key('l', 0), Eigen::Vector2d(at * Eigen::Vector2d(std::cos(angle), std::sin(angle))));
    s.graph.emplace<Range<SE2, Eigen::Vector2d>>(pose(9), Key('l', 0), 1.0,
                                                 Noise::isotropic(1, 0.1));
    const ContinuousMarginals marginals(s.graph, s.initial);
    EXPECT_FALSE(marginals.valid());
    EXPECT_EQ(marginals.under_constrained(), std::vector<Key>{Key('l', 0)});
    EXPECT_THROW(marginals.covariance(Key('l', 0)), Error);
    EXPECT_THROW(marginals.joint_covariance({pose(1), Key('l', 0)}), Error);
    const Covariances all = marginals.all();
    EXPECT_FALSE(all.contains(Key('l', 0)));
    EXPECT_EQ(all.size(), 30u);
    for (int i = 0; i < 30; ++i) {
      EXPECT_LT((all.at(pose(i)) - before.at(pose(i))).norm(), 1e-9 * before.at(pose(i)).norm());
    }
    const Eigen::MatrixXd joint = marginals.joint_covariance({pose(3), pose(20)});
    EXPECT_LT((joint.topLeftCorner<3, 3>() - before.at(pose(3))).norm(), 1e-9 * joint.norm());
  }
}

TEST(ContinuousMarginals, HaveNoVarianceForWhatIsNotMeasured) {
  using Point = Eigen::Vector2d;
  HybridGraph graph;
  Estimate at;
  at.values.insert(Key('l', 0), Point(10, 0));
  graph.emplace<Prior<Point>>(Key('l', 0), Point(0, 0), Noise::isotropic(2, 0.1), Loss::tukey());
  EXPECT_FALSE(ContinuousMarginals(graph, at).valid());
}

// Straight ahead, so that the variance of the lateral position is that of a sum of turns.
TEST(ContinuousMarginals, OfALongChainAreThoseOfASum) {
  const int n = 60000;
  HybridGraph graph;
  Estimate at;
  const Noise noise = Noise::diagonal(Eigen::Vector3d(0.02, 0.02, 0.01));
  at.values.insert(pose(0), SE2());
  graph.emplace<Prior<SE2>>(pose(0), SE2(), Noise::isotropic(3, 1e-3));
  for (int i = 1; i < n; ++i) {
    at.values.insert(pose(i), SE2(i, 0, 0));
    graph.emplace<BetweenSE2>(pose(i - 1), pose(i), SE2(1, 0, 0), noise);
  }
  const ContinuousMarginals marginals(graph, at);
  ASSERT_TRUE(marginals.valid());
  const Eigen::MatrixXd sigma = marginals.covariance(pose(n - 1));
  const double m = n - 1;
  const double turns = 1e-6 * m * m + 1e-4 * (m - 1) * m * (2 * m - 1) / 6;
  EXPECT_NEAR(sigma(1, 1), turns, 1e-3 * turns);
  EXPECT_NEAR(sigma(2, 2), 1e-6 + 1e-4 * m, 1e-3);
  EXPECT_NEAR(sigma(0, 0), 1e-6 + 4e-4 * m, 1e-2);
}

TEST(ContinuousMarginals, RefuseUnknownKeys) {
  const auto s = testing::simulate_loops<SE2, BetweenSE2>(8, 4, 0.05, 7);
  const ContinuousMarginals marginals(s.graph, s.initial);
  EXPECT_THROW(marginals.covariance(pose(8)), Error);
  EXPECT_THROW(marginals.all().at(pose(8)), Error);
}

}  // namespace
}  // namespace hybrid
