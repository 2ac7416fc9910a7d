// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

// Chordal starts of graphs with landmarks.
#include "libhybrid/solvers/chordal.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/geometry/polar.h"
#include "libhybrid/solvers/starts.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

/// Two rounds on a circle with landmarks beside it, seen when near, with `turn_sigma` [rad] of
/// noise in the rotation of each step.
template <class Pose>
struct Round {
  using Point = typename Pose::Point;
  static constexpr int kPoint = Point::RowsAtCompileTime;
  static constexpr int kPoses = 200;  // in each round
  static constexpr int kLandmarks = 40;
  HybridGraph graph;
  Values truth, odometry;

  Round(double turn_sigma, std::uint64_t seed) {
    testing::Random random(seed);
    const double turn = 2 * M_PI / kPoses;
    typename Pose::Tangent motion = Pose::Tangent::Zero();
    motion[0] = 1.0;
    motion[Pose::kDim - 1] = turn;
    Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(Pose::kDim, 0.05);
    sigmas.tail(Pose::kDim - kPoint).setConstant(turn_sigma);
    Pose pose, guess;
    add(Key('x', 0), pose, guess);
    graph.emplace<Prior<Pose>>(Key('x', 0), pose, Noise::isotropic(Pose::kDim, 1e-3));
    for (std::uint64_t i = 1; i < 2 * kPoses; ++i) {
      typename Pose::Tangent error;
      for (int k = 0; k < Pose::kDim; ++k) error[k] = random.normal(sigmas[k]);
      const Pose z = Pose::exp(motion) * Pose::exp(error);
      graph.emplace<Between<Pose>>(Key('x', i - 1), Key('x', i), z, Noise::diagonal(sigmas));
      pose = pose * Pose::exp(motion);
      guess = guess * z;
      add(Key('x', i), pose, guess);
    }
    for (std::uint64_t l = 0; l < kLandmarks; ++l) {
      const double a = 2 * M_PI * static_cast<double>(l) / kLandmarks;
      const double side = random.uniform(1.0, 4.0);
      Point p = Point::Zero();
      p[0] = (1 / turn + side) * std::sin(a);
      p[1] = 1 / turn - (1 / turn + side) * std::cos(a);
      if (kPoint == 3) p[kPoint - 1] = random.normal();
      see(Key('l', l), p, random);
    }
  }

  void add(Key key, const Pose& pose, const Pose& guess) {
    truth.insert(key, pose);
    odometry.insert(key, guess);
  }

  void see(Key key, const Point& p, testing::Random& random) {
    truth.insert(key, p);
    Eigen::VectorXd sigmas = Eigen::VectorXd::Constant(kPoint, 0.01);
    sigmas[0] = 0.05;
    for (std::uint64_t i = 0; truth.contains(Key('x', i)); ++i) {
      const Pose pose = truth.at<Pose>(Key('x', i));
      const Point seen = pose.rotation().matrix().transpose() * (p - pose.translation());
      if (seen.norm() > 8.0) continue;
      Point z = to_polar(seen);
      for (int k = 0; k < kPoint; ++k) z[k] += random.normal(sigmas[k]);
      graph.emplace<BearingRange<Pose>>(Key('x', i), key, z, Noise::diagonal(sigmas));
      if (!odometry.contains(key)) {
        odometry.insert(key, Point(odometry.at<Pose>(Key('x', i)) * seen));
      }
    }
  }

  std::vector<ContinuousFactorPtr> factors() const {
    std::vector<ContinuousFactorPtr> all;
    graph.continuous().for_each(
        [&](Handle, const ContinuousFactorPtr& factor) { all.push_back(factor); });
    return all;
  }
};

/// The objective of the minimum next to some values.
template <class Pose>
AlternatingResult solved(const Round<Pose>& world, const Values& start) {
  return alternate(world.graph, {start, {}});
}

template <class Pose>
void expect_optimum_from_nowhere() {
  const Round<Pose> world(0.02, 1);
  const double planted = solved(world, world.truth).report.objective;
  Values start = world.truth;
  for (Key key : start.keys()) {
    if (key == Key('x', 0)) continue;
    if (key.letter() == 'x') {
      start.update(key, Pose());
    } else {
      start.update(key, typename Pose::Point(Pose::Point::Zero()));
    }
  }
  const Values found = chordal_initialization(world.factors(), start);
  EXPECT_NEAR(solved(world, found).report.objective, planted, 1e-3);
}

TEST(Chordal, SeveralPriorsMayHoldOnePose) {
  const Key a('x', 0), b('x', 1);
  Values initial;
  initial.insert(a, SE2());
  initial.insert(b, SE2());
  const Noise noise = Noise::isotropic(3, 0.1);
  const std::vector<ContinuousFactorPtr> factors = {
      std::make_shared<Prior<SE2>>(a, SE2(), noise), std::make_shared<Prior<SE2>>(a, SE2(), noise),
      std::make_shared<BetweenSE2>(a, b, SE2(2, 1, 0.5), noise)};
  const Values values = chordal_initialization(factors, initial);
  EXPECT_NEAR(values.at<SE2>(b).x(), 2, 1e-6);
  EXPECT_NEAR(values.at<SE2>(b).angle(), 0.5, 1e-6);
}

TEST(Chordal, LandmarksArePlacedWithThePoses) {
  expect_optimum_from_nowhere<SE2>();
  expect_optimum_from_nowhere<SE3>();
}

TEST(Chordal, PointsThatNoPoseSeesStayAsTheyAre) {
  HybridGraph graph;
  Values values;
  const Key a('x', 0), b('x', 1), error('e', 0);
  values.insert(a, SE2());
  values.insert(b, SE2(9, 9, 2));
  values.insert(error, Eigen::Vector2d(3, 4));
  std::vector<ContinuousFactorPtr> factors{
      std::make_shared<Prior<SE2>>(a, SE2(), Noise::isotropic(3, 0.1)),
      std::make_shared<BetweenSE2>(a, b, SE2(1, 0, 0), Noise::isotropic(3, 0.1)),
      std::make_shared<Prior<Eigen::Vector2d>>(error, Eigen::Vector2d(0, 0),
                                               Noise::isotropic(2, 1))};
  const Values found = chordal_initialization(factors, values);
  EXPECT_NEAR(found.at<SE2>(b).x(), 1, 1e-6);
  EXPECT_EQ(found.at<Eigen::Vector2d>(error), Eigen::Vector2d(3, 4));
}

template <class Pose>
void expect_lower_minimum(double turn_sigma) {
  int lower = 0;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Round<Pose> world(turn_sigma, seed);
    const double planted = solved(world, world.truth).report.objective;
    const AlternatingResult alone = solved(world, world.odometry);
    const ChordalTrial trial = try_chordal_start(world.graph, alone.estimate);
    if (alone.report.objective < planted + 1.0) continue;
    ++lower;
    ASSERT_TRUE(trial.better);
    EXPECT_NEAR(trial.objective, planted, 1e-3);
    EXPECT_FALSE(try_chordal_start(world.graph, *trial.better).tried);
  }
  EXPECT_GT(lower, 0) << "odometry leads to the optimum";
}

TEST(ChordalTrial, LeavesTheMinimumOfABadHeading) {
  expect_lower_minimum<SE2>(0.09);
  expect_lower_minimum<SE3>(0.09);
}

TEST(ChordalTrial, IsNotMadeWhereNoiseExplainsTheEstimate) {
  const Round<SE2> world(0.01, 3);
  const Estimate estimate = solved(world, world.odometry).estimate;
  EXPECT_FALSE(try_chordal_start(world.graph, estimate).tried);
  EXPECT_FALSE(try_chordal_start({}, {}).tried);
}

}  // namespace
}  // namespace hybrid
