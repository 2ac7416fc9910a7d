// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/association/constellation.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <random>

#include "libhybrid/geometry/se2.h"
#include "libhybrid/geometry/se3.h"

namespace hybrid {
namespace {

constexpr double kSigma = 0.2;     // of a landmark [m]
constexpr double kDensity = 0.01;  // per m^2 or m^3
constexpr double kDecisive = 4.6;

/// Landmarks strewn at random about two visits of one place, or of two places.
template <class Pose>
class World {
 public:
  using Point = typename Pose::Point;
  static constexpr int kDim = Point::RowsAtCompileTime;

  explicit World(unsigned seed) : random_(seed) {}

  Point point() {
    Point p;
    for (int k = 0; k < kDim; ++k) p[k] = uniform(-20, 20);
    return p;
  }
  Point noise(double sigma) {
    Point p;
    for (int k = 0; k < kDim; ++k) p[k] = sigma * gauss_(random_);
    return p;
  }
  double uniform(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random_);
  }

  /// `common` landmarks of both, in the same order, and `more` of each alone. T_a_b is off by what
  /// its covariance says.
  ConstellationMatchProblem<Pose> question(int common, int more, double drift_m, double drift_rad) {
    ConstellationMatchProblem<Pose> q;
    typename Pose::Tangent variances;
    variances.setConstant(drift_rad * drift_rad);
    variances.template head<kDim>().setConstant(drift_m * drift_m);
    q.covariance = variances.asDiagonal();
    typename Pose::Tangent off;
    for (int k = 0; k < Pose::kDim; ++k) off[k] = std::sqrt(variances[k]) * gauss_(random_);
    truth = Pose();
    q.T_a_b = truth * Pose::exp(off);
    for (int i = 0; i < common; ++i) {
      const Point p = point();
      add(p, q.b);
      add(truth * p, q.a);
    }
    for (int i = 0; i < more; ++i) {
      add(point(), q.a);
      add(point(), q.b);
    }
    q.class_log_likelihood_ratio.setZero(common + more, common + more);
    q.log_density = std::log(kDensity);
    return q;
  }

  Pose truth;

 private:
  void add(const Point& p, Constellation<Pose>& to) {
    to.points.push_back(p + noise(kSigma));
    to.covariances.push_back(kSigma * kSigma * Constellation<Pose>::Matrix::Identity());
  }

  std::mt19937 random_;
  std::normal_distribution<double> gauss_;
};

template <class Pose>
class Constellations : public ::testing::Test {};
using Poses = ::testing::Types<SE2, SE3>;
TYPED_TEST_SUITE(Constellations, Poses);

TYPED_TEST(Constellations, APlaceIsRecognisedAfterLargeDrift) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    World<TypeParam> world(seed);
    const auto q = world.question(10, 5, 8.0, 0.15);
    const auto answers = match_places(q);
    ASSERT_FALSE(answers.empty()) << seed;
    EXPECT_LT(answers.front().cost, -kDecisive) << seed;
    EXPECT_LT(world.truth.between(answers.front().T_a_b).log().norm(), 0.5) << seed;
    int right = 0;
    for (const auto& [i, j] : answers.front().pairs) right += i == j && i < 10 ? 1 : 0;
    EXPECT_GE(right, 9) << seed;
  }
}

TYPED_TEST(Constellations, OtherPlacesAreNotTakenForOne) {
  int wrong = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    World<TypeParam> world(seed);
    auto q = world.question(0, 12, 5.0, 0.1);
    q.a.covers = q.b.covers = [](const auto& p) { return p.cwiseAbs().maxCoeff() < 20; };
    const auto answers = match_places(q);
    if (!answers.empty() && answers.front().cost < -kDecisive) ++wrong;
  }
  EXPECT_LE(wrong, 1);
}

// With a rotation that is known, all is linear: the evidence is that of one Gaussian.
TEST(Constellation, EvidenceIsThatOfTheStackedDifferences) {
  World<SE2> world(3);
  auto q = world.question(4, 0, 3.0, 1e-9);
  const auto answers = match_places(q);
  ASSERT_EQ(answers.front().pairs.size(), 4U);
  Eigen::VectorXd d(8);
  Eigen::MatrixXd S(8, 8);
  for (int i = 0; i < 4; ++i) {
    d.segment<2>(2 * i) = q.T_a_b * q.b.points[i] - q.a.points[i];
    for (int j = 0; j < 4; ++j) {
      S.block<2, 2>(2 * i, 2 * j) =
          (9.0 + (i == j ? 2 * kSigma * kSigma : 0.0)) * Eigen::Matrix2d::Identity();
    }
  }
  const double expected = 0.5 * d.dot(S.ldlt().solve(d)) +
                          0.5 * std::log((2 * M_PI * S).determinant()) + 4 * std::log(kDensity);
  EXPECT_NEAR(answers.front().cost, expected, 1e-6);
}

TEST(Constellation, WhatIsMissingHasItsPrice) {
  World<SE2> world(1);
  auto q = world.question(8, 3, 2.0, 0.05);
  const double before = match_places(q).front().cost;
  q.a.covers = q.b.covers = [](const Eigen::Vector2d&) { return true; };
  EXPECT_NEAR(match_places(q).front().cost, before + 6 * q.missed, 1e-9);
}

TEST(Constellation, LandmarksThatCannotBeOneAreNoPair) {
  World<SE2> world(2);
  auto q = world.question(8, 0, 2.0, 0.05);
  q.class_log_likelihood_ratio(3, 3) = -std::numeric_limits<double>::infinity();
  for (const auto& answer : match_places(q)) {
    for (const auto& [i, j] : answer.pairs) EXPECT_FALSE(i == 3 && j == 3);
  }
}

TEST(Constellation, ClassesSpeakForAPlace) {
  World<SE2> world(5);
  auto q = world.question(6, 4, 5.0, 0.1);
  const double before = match_places(q).front().cost;
  q.class_log_likelihood_ratio.setConstant(-std::log(4.0));
  q.class_log_likelihood_ratio.diagonal().setConstant(std::log(4.0));
  EXPECT_LT(match_places(q).front().cost, before - 5 * std::log(4.0));
}

TEST(Constellation, TwoLandmarksAreTheLeast) {
  World<SE2> world(6);
  EXPECT_TRUE(match_places(world.question(1, 0, 1.0, 0.1)).empty());
  EXPECT_TRUE(match_places(world.question(0, 0, 1.0, 0.1)).empty());
}

}  // namespace
}  // namespace hybrid
