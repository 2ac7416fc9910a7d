// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/association_factor.h"

#include <gtest/gtest.h>

#include <memory>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/semantic.h"
#include "libhybrid/smoother/incremental.h"

namespace hybrid {
namespace {

const DiscreteKey kChoice{Key('a', 0), 3};
const DiscreteKey kClass0{Key('s', 0), 2}, kClass1{Key('s', 1), 2};
const Noise kNoise = Noise::isotropic(2, 0.1);

ContinuousFactorPtr sighting(int landmark, double range) {
  return std::make_shared<BearingRange2>(Key('x', 0), Key('l', landmark),
                                         Eigen::Vector2d(range, 0.0), kNoise);
}

std::shared_ptr<AssociationFactor> factor(double range) {
  std::vector<AssociationOption> options(3);
  options[0] = {sighting(0, range), 0.5, likelihood_table(kClass0, {0.9, 0.1})};
  options[1] = {sighting(1, range), 0.7, likelihood_table(kClass1, {0.9, 0.1})};
  options[2].constant = 4.0;
  return std::make_shared<AssociationFactor>(kChoice, options);
}

Values two_landmarks() {
  Values values;
  values.insert(Key('x', 0), SE2());
  values.insert(Key('l', 0), Eigen::Vector2d(5.8, 0));
  values.insert(Key('l', 1), Eigen::Vector2d(8, 0));
  return values;
}

// eq. 8a and 8b: the tables at fixed C and the component at fixed D are one factor.
TEST(AssociationFactor, TablesSumToTheCostOfTheComponent) {
  const auto f = factor(5.3);
  const Values values = two_landmarks();
  const std::vector<Table> tables = f->given(values);
  for (int a = 0; a < 3; ++a) {
    for (int s0 = 0; s0 < 2; ++s0) {
      for (int s1 = 0; s1 < 2; ++s1) {
        Assignment assignment;
        assignment.set(kChoice.key, a);
        assignment.set(kClass0.key, s0);
        assignment.set(kClass1.key, s1);
        double sum = 0;
        for (const Table& table : tables) sum += table.cost(assignment);
        EXPECT_NEAR(sum, f->cost(values, assignment), 1e-12);
      }
    }
  }
}

TEST(AssociationFactor, RefusesWhatDoesNotFit) {
  std::vector<AssociationOption> options(2);
  EXPECT_THROW(AssociationFactor(kChoice, options), Error);
  options.resize(3);
  options[0].classes = Table({kClass0, kClass1}, std::vector<double>(4, 0.0));
  EXPECT_THROW(AssociationFactor(kChoice, options), Error);
}

// Geometry leaves it open which landmark was seen; what becomes known of the pose decides it, and
// the class follows.
TEST(AssociationFactor, TheSmootherRevisesTheChoice) {
  IncrementalSmoother smoother;
  Delta delta;
  delta.values = two_landmarks();
  delta.continuous.push_back(
      std::make_shared<Prior<SE2>>(Key('x', 0), SE2(), Noise::isotropic(3, 2.0)));
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d at = delta.values.at<Eigen::Vector2d>(Key('l', i));
    delta.continuous.push_back(std::make_shared<Prior<Eigen::Vector2d>>(Key('l', i), at, kNoise));
  }
  delta.discrete.push_back(prior_table(kClass0, {0.5, 0.5}));
  delta.discrete.push_back(prior_table(kClass1, {0.2, 0.8}));
  delta.hybrid.push_back(factor(6.0));
  smoother.update(delta);
  EXPECT_EQ(smoother.assignment().at(kChoice.key), 0);
  EXPECT_EQ(smoother.assignment().at(kClass0.key), 0);
  EXPECT_EQ(smoother.assignment().at(kClass1.key), 1);

  Delta more;
  more.continuous.push_back(
      std::make_shared<Prior<SE2>>(Key('x', 0), SE2({2, 0}, SO2()), Noise::isotropic(3, 0.01)));
  const UpdateReport report = smoother.update(more);
  EXPECT_EQ(smoother.assignment().at(kChoice.key), 1);
  EXPECT_EQ(smoother.assignment().at(kClass1.key), 0);
  EXPECT_TRUE(report.exact);
  for (std::size_t i = 1; i < report.objectives.size(); ++i) {
    EXPECT_LE(report.objectives[i], report.objectives[i - 1] + 1e-9);
  }
}

}  // namespace
}  // namespace hybrid
