// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/hybrid/mixture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"

namespace hybrid {
namespace {

using Vector2Prior = Prior<Eigen::Vector2d>;

const Key kA{'l', 0};
const Key kB{'l', 1};
const DiscreteKey kD{Key('d', 0), 2};
const DiscreteKey kE{Key('e', 0), 3};

ContinuousFactorPtr prior(Key key, double x, double sigma) {
  return std::make_shared<Vector2Prior>(key, Eigen::Vector2d(x, 0.0), Noise::isotropic(2, sigma));
}

/// -log of a Gaussian in the plane with standard deviation sigma, at a distance from its mean.
double minus_log_gaussian(double distance, double sigma) {
  return 0.5 * std::pow(distance / sigma, 2) + std::log(2.0 * std::acos(-1.0) * sigma * sigma);
}

Values two_points() {
  Values values;
  values.insert(kA, Eigen::Vector2d(1.0, 0.0));
  values.insert(kB, Eigen::Vector2d(5.0, 0.0));
  return values;
}

/// Six components over (d0, e0): they differ in variables, covariance and weight; the last is
/// constant.
Mixture six() {
  return Mixture({kD, kE}, {{prior(kA, 0.0, 1.0), 0.1},
                            {prior(kA, 0.0, 3.0), 0.2},
                            {prior(kB, 0.0, 1.0), 0.3},
                            {prior(kB, 0.0, 3.0), 0.4},
                            {prior(kB, 5.0, 0.1), 0.5, true},
                            {nullptr, 6.5}});
}

TEST(Mixture, CostsAreMinusLogDensities) {
  const Values values = two_points();
  const Mixture mixture = six();
  EXPECT_EQ(mixture.keys(), (std::vector<Key>{kA, kB}));
  const std::vector<double> expected{
      0.1 + minus_log_gaussian(1.0, 1.0), 0.2 + minus_log_gaussian(1.0, 3.0),
      0.3 + minus_log_gaussian(5.0, 1.0), 0.4 + minus_log_gaussian(5.0, 3.0),
      0.5 + minus_log_gaussian(0.0, 0.1), 6.5};
  const std::vector<Table> tables = mixture.given(values);
  ASSERT_EQ(tables.size(), 1u);
  for (int d = 0; d < 2; ++d) {
    for (int e = 0; e < 3; ++e) {
      Assignment assignment;
      assignment.set(kD.key, d);
      assignment.set(kE.key, e);
      EXPECT_NEAR(tables[0].cost(assignment), expected[3 * d + e], 1e-12);
      EXPECT_NEAR(mixture.cost(values, assignment), expected[3 * d + e], 1e-12);
      EXPECT_EQ(mixture.given(assignment).index, 3 * d + e);
      EXPECT_EQ(mixture.given(assignment).weak, d == 1 && e == 1);
    }
  }
}

TEST(Mixture, RefusesWhatDoesNotFit) {
  EXPECT_THROW(Mixture({kD, kE}, {{prior(kA, 0.0, 1.0), 0.0}}), Error);
  EXPECT_THROW(Mixture({}, {{prior(kA, 0.0, 1.0), 0.0}}), Error);
  for (const double wrong : {std::nan(""), double(-INFINITY)}) {
    for (const ContinuousFactorPtr& factor : {prior(kA, 0.0, 1.0), ContinuousFactorPtr()}) {
      try {
        Mixture({kD}, {{prior(kA, 0.0, 1.0), 0.0}, {factor, wrong}});
        ADD_FAILURE() << wrong;
      } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("component 1 of a mixture over d0"),
                  std::string::npos)
            << error.what();
      }
    }
  }
  EXPECT_NO_THROW(Mixture({kD}, {{prior(kA, 0.0, 1.0), INFINITY}, {nullptr, 0.0}}));
  EXPECT_THROW(Mixture({kD}, {{prior(kA, 0.0, 1.0), 0.0},
                              {std::make_shared<Prior<SE2>>(kA, SE2(), Noise::unit(3)), 0.0}}),
               Error);
  Assignment assignment;
  EXPECT_THROW(six().given(assignment), Error);
  assignment.set(kD.key, 0);
  assignment.set(kE.key, 3);
  EXPECT_THROW(six().given(assignment), Error);
}

TEST(OutlierMixture, WeighsInlierAgainstOutlier) {
  const HybridFactorPtr factor =
      make_outlier_mixture(kD, prior(kA, 0.0, 1.0), prior(kA, 0.0, 10.0), 0.9, 0.1);
  Assignment inlier, outlier;
  inlier.set(kD.key, 0);
  outlier.set(kD.key, 1);
  const Values values = two_points();
  EXPECT_NEAR(factor->cost(values, inlier), minus_log_gaussian(1.0, 1.0) - std::log(0.9), 1e-12);
  EXPECT_NEAR(factor->cost(values, outlier), minus_log_gaussian(1.0, 10.0) - std::log(0.1), 1e-12);
  EXPECT_THROW(make_outlier_mixture(kD, prior(kA, 0, 1), prior(kA, 0, 2), 0.0, 1.0), Error);
}

// An outlier model of some information counts in full; only one a million times wider is weak.
TEST(OutlierMixture, IsWeakWhereItSaysNextToNothing) {
  Assignment inlier, outlier;
  inlier.set(kD.key, 0);
  outlier.set(kD.key, 1);
  const auto mixture = [](double wider) {
    return make_outlier_mixture(kD, prior(kA, 0.0, 0.1), prior(kA, 0.0, 0.1 * wider), 0.9, 0.1);
  };
  for (const double wider : {0.5, 10.0, 999.0}) {
    EXPECT_FALSE(mixture(wider)->given(outlier).weak) << wider;
  }
  EXPECT_TRUE(mixture(1001.0)->given(outlier).weak);
  EXPECT_FALSE(mixture(1001.0)->given(inlier).weak);
  EXPECT_FALSE(make_outlier_mixture(kD, prior(kA, 0, 1), nullptr, 0.9, 0.1)->given(outlier).weak);
}

}  // namespace
}  // namespace hybrid
