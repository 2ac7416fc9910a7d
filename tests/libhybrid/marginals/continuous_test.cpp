// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/marginals/continuous.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "libhybrid/factors/bearing_range.h"
#include "tests/support/simulated_graphs.h"

namespace hybrid {
namespace {

using testing::pose;

/// J'J assembled densely, variables in order of their slots.
Eigen::MatrixXd dense_information(const HybridGraph& graph, const Estimate& estimate) {
  std::unordered_map<Key, int> start;
  int n = 0;
  for (Key key : estimate.values.keys()) {
    start[key] = n;
    n += estimate.values.type(key).dim;
  }
  Eigen::MatrixXd information = Eigen::MatrixXd::Zero(n, n);
  const auto add = [&](const ContinuousFactor& factor) {
    Eigen::VectorXd r(factor.rows());
    Eigen::MatrixXd J(factor.rows(), factor.cols());
    factor.linearize(gather(factor.keys(), factor.types(), estimate.values).data(), r.data(),
                     J.data());
    Eigen::MatrixXd wide = Eigen::MatrixXd::Zero(factor.rows(), n);
    int col = 0;
    for (std::size_t i = 0; i < factor.keys().size(); ++i) {
      const int dim = factor.types()[i].dim;
      wide.middleCols(start[factor.keys()[i]], dim) = J.middleCols(col, dim);
      col += dim;
    }
    information += wide.transpose() * wide;
  };
  graph.continuous().for_each([&](Handle, const ContinuousFactorPtr& factor) { add(*factor); });
  graph.hybrid().for_each([&](Handle, const HybridFactorPtr& factor) {
    add(*factor->given(estimate.assignment).factor);
  });
  return information;
}

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

TEST(ContinuousMarginals, CountWeakComponentsUnlessToldOtherwise) {
  const auto s = testing::simulate_outliers(20, 10, 0.3, false, 3);
  expect_covariances_of_dense_inverse(s.graph, s.initial, 1e-9);
  MarginalOptions uncoupled;
  uncoupled.weak = WeakComponents::kUncoupled;
  const Eigen::MatrixXd close =
      ContinuousMarginals(s.graph, s.initial, uncoupled).covariance(pose(19));
  const Eigen::MatrixXd exact = ContinuousMarginals(s.graph, s.initial).covariance(pose(19));
  EXPECT_LT((close - exact).norm(), 0.2 * exact.norm());
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

TEST(ContinuousMarginals, RefuseUnknownKeys) {
  const auto s = testing::simulate_loops<SE2, BetweenSE2>(8, 4, 0.05, 7);
  const ContinuousMarginals marginals(s.graph, s.initial);
  EXPECT_THROW(marginals.covariance(pose(8)), Error);
  EXPECT_THROW(marginals.all().at(pose(8)), Error);
}

}  // namespace
}  // namespace hybrid
