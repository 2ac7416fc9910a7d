// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/hybrid/semantic.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::Random;

const Key kPose{'x', 0};
const Key kPoint{'l', 4};
const DiscreteKey kClass{{'c', 4}, 3};

template <class Pose>
void check_decomposition() {
  using Point = typename Pose::Point;
  Random random{21};
  Values values;
  values.insert(kPose, random.value<Pose>());
  values.insert(kPoint, random.value<Point>());
  Point z = random.value<Point>();
  z[0] = std::abs(z[0]);
  const Pose T_robot_sensor = random.value<Pose>();
  const Noise noise = random.noise(Point::RowsAtCompileTime, 0.5);
  const std::vector<double> phi{0.2, 0.7, 0.05};
  const HybridFactorPtr factor =
      make_semantic_bearing_range<Pose>(kPose, kPoint, kClass, z, noise, phi, T_robot_sensor);
  const BearingRange<Pose> psi(kPose, kPoint, z, noise, T_robot_sensor);
  const std::vector<Table> tables = factor->given(values);
  ASSERT_EQ(tables.size(), 1u);
  for (int s = 0; s < kClass.cardinality; ++s) {
    Assignment assignment;
    assignment.set(kClass.key, s);
    // -log (phi(s) psi), by each of the three ways to ask for it.
    const double expected = -std::log(phi[s]) + psi.cost(values) + psi.log_normalizer();
    EXPECT_NEAR(factor->cost(values, assignment), expected, 1e-12);
    EXPECT_NEAR(tables[0].cost(assignment), expected, 1e-12);
    const Component component = factor->given(assignment);
    EXPECT_NEAR(component.constant, -std::log(phi[s]), 1e-15);
    EXPECT_EQ(component.index, 0);
    EXPECT_FALSE(component.weak);
    EXPECT_EQ(component.factor->keys(), factor->keys());
  }
}

TEST(Semantic, IsClassLikelihoodTimesGaussian) {
  check_decomposition<SE2>();
  check_decomposition<SE3>();
}

TEST(Semantic, ImpossibleClassCostsInfinity) {
  const Table table = likelihood_table(kClass, {0.5, 0.0, 0.5});
  EXPECT_TRUE(std::isinf(table.costs()[1]));
  EXPECT_NEAR(table.costs()[0], std::log(2.0), 1e-15);
}

TEST(Semantic, RefusesLikelihoodsThatAreNone) {
  EXPECT_THROW(likelihood_table(kClass, {0.5, 0.5}), Error);
  EXPECT_THROW(likelihood_table(kClass, {0.0, 0.0, 0.0}), Error);
  EXPECT_THROW(likelihood_table(kClass, {0.5, -0.1, 0.5}), Error);
  EXPECT_THROW(likelihood_table(kClass, {0.5, std::nan(""), 0.5}), Error);
}

TEST(Semantic, DetectionIsAColumnOfTheConfusionMatrix) {
  Eigen::MatrixXd confusion(3, 3);
  confusion << 0.7, 0.2, 0.1, 0.3, 0.6, 0.1, 0.0, 0.1, 0.9;
  EXPECT_EQ(likelihood_of_detection(confusion, 1), (std::vector<double>{0.2, 0.6, 0.1}));
  EXPECT_THROW(likelihood_of_detection(confusion, 3), Error);
  EXPECT_THROW(likelihood_of_detection(confusion, -1), Error);
  confusion(0, 0) = 0.8;
  EXPECT_THROW(likelihood_of_detection(confusion, 1), Error);
}

TEST(Semantic, ScoresAreDividedByTheFrequenciesOfTraining) {
  const auto uniform = likelihood_of_scores({0.6, 0.3, 0.0});
  EXPECT_NEAR(uniform[0] / uniform[1], 2.0, 1e-12);
  EXPECT_NEAR(uniform[2] / uniform[0], 1e-6 / 0.6, 1e-12);
  const auto skewed = likelihood_of_scores({0.6, 0.3, 0.1}, {0.6, 0.3, 0.1});
  EXPECT_NEAR(skewed[0], skewed[2], 1e-12);
  EXPECT_THROW(likelihood_of_scores({0.6, 0.4}, {1.0}), Error);
  EXPECT_THROW(likelihood_of_scores({0.6, 0.4}, {1.0, 0.0}), Error);
  EXPECT_THROW(likelihood_of_scores({0.0, 0.0}), Error);
}

TEST(WeightedFactor, TakesTablesOverSeveralVariablesAndNoNullFactor) {
  const DiscreteKey other{{'d', 0}, 2};
  const auto prior =
      std::make_shared<BearingRange2>(kPose, kPoint, Eigen::Vector2d(1.0, 0.0), Noise::unit(2));
  const WeightedFactor factor(prior, Table({kClass, other}, {0, 1, 2, 3, 4, 5}));
  Assignment assignment;
  assignment.set(kClass.key, 2);
  assignment.set(other.key, 1);
  EXPECT_EQ(factor.given(assignment).constant, 5.0);
  EXPECT_THROW(WeightedFactor(nullptr, Table({other}, {0, 1})), Error);
  EXPECT_THROW(WeightedFactor(prior, Table({}, {0})), Error);
}

}  // namespace
}  // namespace hybrid
