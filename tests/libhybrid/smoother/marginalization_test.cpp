// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/marginalization.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <memory>
#include <random>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"
#include "tests/support/dense_system.h"

namespace hybrid {
namespace {

using testing::DenseSystem;

/// A chain of measured motions of which the poses between the ends are marginalised.
template <class Pose>
void expect_all_information(const std::vector<Pose>& motions) {
  HybridGraph graph;
  Estimate estimate;
  std::vector<Handle> factors;
  std::vector<Key> between;
  const auto noise = Noise::diagonal(Pose::Tangent::Constant(0.05));
  const auto key = [](std::size_t i) { return Key('x', static_cast<std::uint64_t>(i)); };
  Pose pose;
  estimate.values.insert(key(0), pose);
  for (std::size_t i = 0; i < motions.size(); ++i) {
    pose = pose * motions[i];
    estimate.values.insert(key(i + 1), pose);
    if (i > 0) between.push_back(key(i));
    factors.push_back(
        graph.add(std::make_shared<Between<Pose>>(key(i), key(i + 1), motions[i], noise)));
  }
  const auto made = marginalize(graph, estimate.values, estimate.assignment, between, factors);
  ASSERT_EQ(made.delta.continuous.size(), 1U);
  EXPECT_TRUE(made.undetermined.empty());

  // The covariance of the relative pose is the sum of those of the motions.
  constexpr int kDim = Pose::kDim;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(kDim, kDim);
  for (const Pose& motion : motions) {
    const auto Ad = motion.inverse().adjoint();
    covariance = Ad * covariance * Ad.transpose() + 0.0025 * Pose::Jacobian::Identity();
  }
  const ContinuousFactor& prior = *made.delta.continuous.front();
  Eigen::VectorXd r(prior.rows());
  Eigen::MatrixXd J(prior.rows(), prior.cols());
  const auto x = gather(prior.keys(), prior.types(), estimate.values);
  prior.linearize(x.data(), r.data(), J.data());
  EXPECT_EQ(prior.rows(), kDim);
  const auto last = J.rightCols(kDim);  // keys in order: the first pose, the last
  EXPECT_EQ(prior.keys().back(), key(motions.size()));
  EXPECT_LT((last.transpose() * last * covariance - Eigen::MatrixXd::Identity(kDim, kDim)).norm(),
            1e-6);
}

TEST(Marginalization, OfAStraightChainKeepsAllThatItSays) {
  for (const double step : {0.0, 0.1, 1.0, 1.5, 30.0}) {
    for (const int n : {2, 3, 10}) {
      expect_all_information(std::vector<SE2>(n, SE2(step, 0, 0)));
      expect_all_information(std::vector<SE3>(n, SE3({step, 0, 0}, SO3())));
    }
  }
}

TEST(Marginalization, OfAChainThatTurnsKeepsAllThatItSays) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  for (int trial = 0; trial < 20; ++trial) {
    std::vector<SE2> planar;
    std::vector<SE3> spatial;
    for (int k = 0; k < 4; ++k) {
      planar.emplace_back(normal(random), normal(random), normal(random));
      spatial.push_back(SE3::exp(SE3::Tangent::NullaryExpr([&]() { return normal(random); })));
    }
    expect_all_information(planar);
    expect_all_information(spatial);
  }
}

/// A landmark of which all its sightings say nothing, as those that a loss rejects, is tied to many
/// poses: what the others are told of each other stays, and the landmark is named.
TEST(Marginalization, OfWhatNothingIsSaidLeavesTheRestAsItIs) {
  HybridGraph graph;
  Values values;
  std::vector<Handle> factors;
  const Key landmark('l', 0);
  values.insert(landmark, Eigen::Vector2d(50.0, 0.0));
  const Noise noise = Noise::isotropic(2, 0.1);
  for (int i = 0; i < 30; ++i) {
    const Key pose('x', static_cast<std::uint64_t>(i));
    values.insert(pose, SE2(i, 0, 0));
    factors.push_back(graph.add(std::make_shared<BearingRange2>(
        pose, landmark, Eigen::Vector2d(5.0, 2.0), noise, SE2(), Loss::tukey())));
  }
  const Marginalization made = marginalize(graph, values, {}, {landmark}, factors);
  EXPECT_TRUE(made.finite);
  EXPECT_EQ(made.undetermined, std::vector<Key>{landmark});
  EXPECT_TRUE(made.follows.isZero());
}

}  // namespace
}  // namespace hybrid
