// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/movers/motion_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <random>
#include <vector>

#include "libhybrid/movers/mover.h"

namespace hybrid {
namespace {

constexpr double kNeverBorn = 1e-300;
constexpr double kSigma = 0.2;  // of a coordinate [m]
constexpr double kSpeed = 3;    // [m/s]
constexpr double kAcceleration = 0.7;
const MotionPrior kPrior{{{kSpeed, kAcceleration}}, {0.1}};

double log_gaussian(const Eigen::VectorXd& r, const Eigen::MatrixXd& S) {
  const Eigen::LLT<Eigen::MatrixXd> llt(S);
  return -0.5 * r.dot(llt.solve(r)) - llt.matrixLLT().diagonal().array().log().sum() -
         0.5 * static_cast<double>(r.size()) * std::log(2 * M_PI);
}

/// Covariance of a coordinate at times a and b after the start, without that of the start: of the
/// integral of a Wiener process and of the velocity at first.
double of_positions(double a, double b) {
  const double m = std::min(a, b), M = std::max(a, b), q = std::pow(kAcceleration, 2);
  return kSpeed * kSpeed * a * b + q * (m * m * M / 2 - m * m * m / 6);
}

/// The same of the velocity at time a and the position at time b.
double of_velocity_and_position(double a, double b) {
  const double q = std::pow(kAcceleration, 2);
  return kSpeed * kSpeed * b + q * (a >= b ? b * b / 2 : a * a / 2 + a * (b - a));
}

template <int D>
std::vector<PointSighting> sightings(int count, double speed, unsigned seed = 3) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, kSigma);
  std::vector<PointSighting> out;
  for (int i = 0; i < count; ++i) {
    PointSighting s;
    s.time = 10 + 0.4 * i + 0.1 * (i % 2);
    for (int k = 0; k < D; ++k) {
      s.point[k] = 5 + k + speed * (k + 1) * (s.time - 10) + noise(random);
      s.covariance(k, k) = kSigma * kSigma;
    }
    out.push_back(s);
  }
  return out;
}

template <int D>
void expect_exact_evidence(double speed) {
  const std::vector<PointSighting> seen = sightings<D>(6, speed);
  MotionFilter<D> filter(seen.front(), kPrior);
  for (std::size_t i = 1; i < seen.size(); ++i) filter.take(seen[i], kNeverBorn);
  const auto n = static_cast<Eigen::Index>(seen.size()) - 1;
  Eigen::MatrixXd standing = Eigen::MatrixXd::Constant(n, n, kSigma * kSigma);
  standing.diagonal().array() += kSigma * kSigma;
  Eigen::MatrixXd moving = standing;
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      moving(i, j) +=
          of_positions(seen[i + 1].time - seen[0].time, seen[j + 1].time - seen[0].time);
    }
  }
  double expected = 0;
  for (int k = 0; k < D; ++k) {
    Eigen::VectorXd r(n);
    for (Eigen::Index i = 0; i < n; ++i) r[i] = seen[i + 1].point[k] - seen[0].point[k];
    expected += log_gaussian(r, moving) - log_gaussian(r, standing);
  }
  EXPECT_NEAR(filter.evidence(), expected, 1e-8 * std::abs(expected) + 1e-8);
}

// The filters give the marginal likelihoods that the joint density of all sightings has.
TEST(MotionFilter, EvidenceIsThatOfTheJointDensity) {
  for (const double speed : {0.0, 0.1, 1.0}) {
    expect_exact_evidence<2>(speed);
    expect_exact_evidence<3>(speed);
  }
}

TEST(MotionFilter, AWalkerMovesAndAPostStands) {
  for (unsigned seed = 1; seed <= 30; ++seed) {
    for (const double speed : {0.0, 0.5, 5.0}) {
      const std::vector<PointSighting> seen = sightings<2>(10, speed, seed);
      MotionFilter<2> filter(seen.front(), kPrior);
      for (std::size_t i = 1; i < seen.size(); ++i) filter.take(seen[i], 0.01);
      EXPECT_EQ(log_odds_of_motion(filter.evidence(), 0.1) > 0, speed > 0) << seed << " " << speed;
    }
  }
}

// A post that is taken for another one does not move there.
TEST(MotionFilter, TwoPostsAreNoMover) {
  std::vector<PointSighting> seen = sightings<2>(12, 0);
  for (std::size_t i = 6; i < seen.size(); ++i) seen[i].point.x() += 4;
  MotionFilter<2> filter(seen.front(), kPrior), without_births(seen.front(), kPrior);
  for (std::size_t i = 1; i < seen.size(); ++i) {
    filter.take(seen[i], 0.01);
    without_births.take(seen[i], kNeverBorn);
  }
  EXPECT_LT(log_odds_of_motion(filter.evidence(), 0.1), 0);
  EXPECT_GT(log_odds_of_motion(without_births.evidence(), 0.1), 0);
}

// A birth in place of a sighting is a density beside that of the thing where it stands, so that the
// two together are no density of one sighting. What that adds to standing is small beside odds
// of 20.
TEST(MotionFilter, BirthsFavourStandingByLittle) {
  constexpr int kSeeds = 100;
  double sum = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    const std::vector<PointSighting> seen = sightings<2>(10, 0, seed);
    MotionFilter<2> filter(seen.front(), kPrior), without_births(seen.front(), kPrior);
    for (std::size_t i = 1; i < seen.size(); ++i) {
      filter.take(seen[i], 0.01);
      without_births.take(seen[i], kNeverBorn);
    }
    sum += without_births.evidence() - filter.evidence();
  }
  EXPECT_LT(std::abs(sum) / kSeeds, 0.3);  // [nat], over ten sightings
}

TEST(MotionFilter, AMeasuredVelocityIsEvidence) {
  for (const double speed : {0.0, 2.0}) {
    PointSighting seen = sightings<2>(1, 0).front();
    seen.has_velocity = true;
    seen.velocity = {speed, 0, 0};
    seen.velocity_covariance = 0.04 * Eigen::Matrix3d::Identity();
    const MotionFilter<2> filter(seen, kPrior);
    const Eigen::Matrix2d still = 0.04 * Eigen::Matrix2d::Identity();
    const Eigen::Matrix2d moving = still + 9 * Eigen::Matrix2d::Identity();
    const Eigen::Vector2d v = seen.velocity.head<2>();
    EXPECT_NEAR(filter.evidence(), log_gaussian(v, moving) - log_gaussian(v, still), 1e-9);
    EXPECT_EQ(filter.evidence() > 0, speed > 0);
  }
}

// Two kinds of the same speed that differ in how steady it is.
TEST(MotionFilter, TheLikeliestKindIsTheOneThatWasSeen) {
  const MotionPrior prior{{{kSpeed, 0.1}, {kSpeed, 5}}, {0.1}};
  for (const bool steady : {true, false}) {
    std::vector<PointSighting> seen = sightings<2>(12, 2);
    for (std::size_t i = 0; i < seen.size() && !steady; i += 2) seen[i].point.y() += 2;
    MotionFilter<2> filter(seen.front(), prior);
    for (std::size_t i = 1; i < seen.size(); ++i) filter.take(seen[i], 0.01);
    EXPECT_EQ(filter.likeliest_kind(), steady ? 0U : 1U);
  }
}

// The smoother gives the conditional density that all sightings leave.
TEST(SmoothedStates, AreThePosteriorOfAllSightings) {
  const std::vector<PointSighting> seen = sightings<2>(5, 0.6);
  const std::vector<double> times = {9.0, seen[0].time, 10.33, seen[3].time, 11.0, 99.0};
  const std::vector<MoverState> states = smoothed_states(seen, times, kPrior, false);
  ASSERT_EQ(states.size(), 4U);  // none before the first sighting, none after the last one
  const auto n = static_cast<Eigen::Index>(seen.size());
  // Of p0, the coordinate at the start: a broad prior that the first sighting outweighs.
  constexpr double kBroad = 1e3;
  const auto since = [&](double t) { return t - seen[0].time; };
  Eigen::MatrixXd S(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      S(i, j) = kBroad + of_positions(since(seen[i].time), since(seen[j].time));
    }
    S(i, i) += kSigma * kSigma;
  }
  for (const MoverState& state : states) {
    const double t = since(state.time);
    Eigen::MatrixXd C(2, n);
    for (Eigen::Index i = 0; i < n; ++i) {
      C(0, i) = kBroad + of_positions(t, since(seen[i].time));
      C(1, i) = of_velocity_and_position(t, since(seen[i].time));
    }
    const Eigen::MatrixXd gain = C * S.inverse();
    const double q = kAcceleration * kAcceleration;
    Eigen::Matrix2d prior;
    prior << kBroad + of_positions(t, t), of_velocity_and_position(t, t),
        of_velocity_and_position(t, t), kSpeed * kSpeed + q * t;
    const Eigen::Matrix2d P = prior - gain * C.transpose();
    for (int k = 0; k < 2; ++k) {
      Eigen::VectorXd z(n);
      for (Eigen::Index i = 0; i < n; ++i) z[i] = seen[i].point[k] - seen[0].point[k];
      const Eigen::Vector2d mean = gain * z;
      EXPECT_NEAR(state.position[k] - seen[0].point[k], mean[0], 1e-4);
      EXPECT_NEAR(state.velocity[k], mean[1], 1e-4);
      EXPECT_NEAR(state.covariance(k, k), P(0, 0), 1e-4);
      EXPECT_NEAR(state.covariance(k, 3 + k), P(0, 1), 1e-4);
      EXPECT_NEAR(state.covariance(3 + k, 3 + k), P(1, 1), 1e-4);
    }
    EXPECT_EQ(state.position.z(), 0);
  }
}

}  // namespace
}  // namespace hybrid
