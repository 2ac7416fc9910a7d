// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/core/noise.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "libhybrid/core/error.h"
#include "libhybrid/core/loss.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Eigen::MatrixXd random_covariance(testing::Random& random, int dim) {
  Eigen::MatrixXd a(dim, dim);
  for (int i = 0; i < a.size(); ++i) a.data()[i] = random.normal();
  return a * a.transpose() + 0.1 * Eigen::MatrixXd::Identity(dim, dim);
}

TEST(Noise, ADimensionBeyondUseIsRefused) {
  EXPECT_THROW(Noise::isotropic(-1, 1.0), Error);
  EXPECT_THROW(Noise::unit(std::numeric_limits<int>::max()), Error);
  EXPECT_THROW(Noise::isotropic(std::numeric_limits<int>::max(), -1.0), Error);
  EXPECT_THROW(Noise::isotropic(0, 1.0), Error);
}

TEST(Noise, AllConstructorsAgree) {
  testing::Random random{41};
  for (int dim = 1; dim <= 6; ++dim) {
    const Eigen::MatrixXd covariance = random_covariance(random, dim);
    const Noise a = Noise::covariance(covariance);
    const Noise b = Noise::information(covariance.inverse());
    for (const Noise& noise : {a, b}) {
      const Eigen::MatrixXd& R = noise.sqrt_information();
      EXPECT_TRUE(R.isUpperTriangular(0.0));
      EXPECT_LT((R.transpose() * R * covariance - Eigen::MatrixXd::Identity(dim, dim)).norm(),
                1e-9);
      EXPECT_LT((noise.covariance() - covariance).norm(), 1e-9 * covariance.norm());
      EXPECT_LT((noise.information() - covariance.inverse()).norm(),
                1e-9 * covariance.inverse().norm());
      // -log of the Gaussian density at its mean, with the dense determinant.
      EXPECT_NEAR(noise.log_normalizer(),
                  0.5 * (dim * std::log(2 * M_PI) + std::log(covariance.determinant())), 1e-9);
    }
  }
  const Noise diagonal = Noise::diagonal(Eigen::Vector2d(2.0, 2.0));
  const Noise isotropic = Noise::isotropic(2, 2.0);
  const Noise full = Noise::covariance(4.0 * Eigen::Matrix2d::Identity());
  EXPECT_LT((diagonal.sqrt_information() - full.sqrt_information()).norm(), 1e-15);
  EXPECT_LT((isotropic.sqrt_information() - full.sqrt_information()).norm(), 1e-15);
  EXPECT_NEAR(diagonal.log_normalizer(), full.log_normalizer(), 1e-15);
  EXPECT_NEAR(Noise::unit(3).log_normalizer(), 1.5 * std::log(2 * M_PI), 1e-15);
}

TEST(Noise, InflatedMultipliesTheCovariance) {
  testing::Random random{43};
  const Eigen::MatrixXd covariance = random_covariance(random, 3);
  const Noise wide = Noise::covariance(covariance).inflated(1e4);
  EXPECT_LT((wide.covariance() - 1e4 * covariance).norm(), 1e-6);
  EXPECT_NEAR(wide.log_normalizer(), Noise::covariance(1e4 * covariance).log_normalizer(), 1e-9);
  EXPECT_THROW(wide.inflated(0.0), Error);
  EXPECT_THROW(wide.inflated(kNaN), Error);
}

TEST(Noise, RefusesWhatIsNoCovariance) {
  EXPECT_THROW(Noise::isotropic(2, 0.0), Error);
  EXPECT_THROW(Noise::isotropic(2, -1.0), Error);
  EXPECT_THROW(Noise::isotropic(2, kInfinity), Error);
  EXPECT_THROW(Noise::isotropic(0, 1.0), Error);
  EXPECT_THROW(Noise::diagonal(Eigen::Vector2d(1.0, kNaN)), Error);
  Eigen::Matrix2d indefinite;
  indefinite << 1.0, 2.0, 2.0, 1.0;
  EXPECT_THROW(Noise::covariance(indefinite), Error);
  EXPECT_THROW(Noise::information(indefinite), Error);
  EXPECT_THROW(Noise::covariance(Eigen::Matrix2d::Zero()), Error);
  Eigen::Matrix2d skew;
  skew << 1.0, 0.5, 0.0, 1.0;
  EXPECT_THROW(Noise::covariance(skew), Error);
  EXPECT_THROW(Noise::information(Eigen::MatrixXd::Identity(2, 3)), Error);
  EXPECT_THROW(Noise::covariance(Eigen::MatrixXd(0, 0)), Error);
  EXPECT_THROW(Noise::covariance(Eigen::Matrix2d::Constant(kNaN)), Error);
}

class LossTest : public ::testing::TestWithParam<Loss> {};

TEST_P(LossTest, WeightIsTheDerivativeOfTheValue) {
  const Loss loss = GetParam();
  for (double s : {0.01, 0.5, 1.0, 3.0, 10.0, 50.0}) {
    const double h = 1e-5 * s;
    const double numeric = (loss.value(s + h) - loss.value(s - h)) / (2 * h);
    EXPECT_NEAR(loss.weight(s), numeric, 1e-8) << "s " << s;
  }
}

TEST_P(LossTest, IsTheSquareNearZeroAndNeverAboveIt) {
  const Loss loss = GetParam();
  EXPECT_EQ(loss.value(0.0), 0.0);
  EXPECT_EQ(loss.weight(0.0), 1.0);
  EXPECT_NEAR(loss.value(1e-6), 1e-6, 1e-11);
  double last = 0.0;
  double last_weight = 1.0;
  for (double s = 0.0; s < 200.0; s += 0.37) {
    const double value = loss.value(s);
    const double weight = loss.weight(s);
    EXPECT_GE(value, last);
    EXPECT_LE(value, s);
    EXPECT_GE(weight, 0.0);
    EXPECT_LE(weight, last_weight);
    last = value;
    last_weight = weight;
  }
  EXPECT_TRUE(std::isfinite(loss.value(1e300)));
  EXPECT_TRUE(std::isfinite(loss.weight(1e300)));
}

INSTANTIATE_TEST_SUITE_P(All, LossTest,
                         ::testing::Values(Loss::none(), Loss::huber(), Loss::huber(0.5),
                                           Loss::cauchy(), Loss::tukey(), Loss::tukey(2.0),
                                           Loss::geman_mcclure(), Loss::geman_mcclure(3.0)));

TEST(Loss, LimitsFarOut) {
  EXPECT_NEAR(Loss::tukey(2.0).value(1e9), 4.0 / 3.0, 1e-12);
  EXPECT_EQ(Loss::tukey(2.0).weight(1e9), 0.0);
  EXPECT_NEAR(Loss::geman_mcclure(2.0).value(1e12), 4.0, 1e-9);
  EXPECT_NEAR(Loss::huber(2.0).value(100.0), 2 * 2.0 * 10.0 - 4.0, 1e-12);
}

}  // namespace
}  // namespace hybrid
