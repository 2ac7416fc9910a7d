// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/window.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <memory>
#include <random>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/factor_of.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/hybrid/semantic.h"

namespace hybrid {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

Key state(int i) {
  return {'x', static_cast<std::uint64_t>(i)};
}

/// x_b = x_a + u, linear.
class Motion : public FactorOf<2, Vector2d, Vector2d> {
 public:
  Motion(Key a, Key b, const Vector2d& u, double sigma)
      : FactorOf({a, b}, Noise::isotropic(2, sigma)), u_(u) {}
  std::string name() const override { return "motion"; }
  Residual evaluate(const Vector2d& a, const Vector2d& b, Matrix2d* Ja,
                    Matrix2d* Jb) const override {
    if (Ja != nullptr) {
      *Ja = -Matrix2d::Identity();
      *Jb = Matrix2d::Identity();
    }
    return b - a - u_;
  }

 private:
  Vector2d u_;
};

// A lag of one on a linear chain is a Kalman filter.
TEST(WindowSmoother, EqualsAKalmanFilterOnALinearProblem) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  WindowSmoother smoother({WindowOptions::Mode::kFixedLag, 1});
  Vector2d mean = Vector2d::Zero();
  Matrix2d covariance = Matrix2d::Identity();
  for (int k = 0; k < 60; ++k) {
    const Vector2d u(1.0, 0.1 * normal(random));
    const Vector2d z(k + normal(random), normal(random));
    Delta delta;
    delta.values.insert(state(k), Vector2d(0.0, 0.0));
    if (k == 0) {
      delta.continuous.push_back(std::make_shared<Prior<Vector2d>>(state(0), mean, Noise::unit(2)));
    } else {
      delta.continuous.push_back(std::make_shared<Motion>(state(k - 1), state(k), u, 0.3));
      mean += u;
      covariance += 0.09 * Matrix2d::Identity();
    }
    delta.continuous.push_back(
        std::make_shared<Prior<Vector2d>>(state(k), z, Noise::isotropic(2, 0.5)));
    const Matrix2d gain = covariance * (covariance + 0.25 * Matrix2d::Identity()).inverse();
    mean += gain * (z - mean);
    covariance = (Matrix2d::Identity() - gain) * covariance;
    const WindowReport report = smoother.update(delta);
    ASSERT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
    EXPECT_LT((smoother.smoother().values().at<Vector2d>(state(k)) - mean).norm(), 1e-9);
    EXPECT_LT((smoother.smoother().joint_covariance({state(k)}) - covariance).norm(), 1e-9);
    EXPECT_LE(smoother.smoother().values().size(), 2u);
  }
  EXPECT_GE(smoother.past().values.size(), 58u);
}

Delta step(int k, std::mt19937& random, const Values& values) {
  std::normal_distribution<double> noise(0.0, 0.02);
  const SE2 motion(1.0, 0.0, 0.3);
  Delta delta;
  if (k == 0) {
    delta.values.insert(state(0), SE2());
    delta.continuous.push_back(
        std::make_shared<Prior<SE2>>(state(0), SE2(), Noise::isotropic(3, 0.01)));
    return delta;
  }
  const SE2 z = motion * SE2::exp({noise(random), noise(random), noise(random)});
  delta.values.insert(state(k), values.at<SE2>(state(k - 1)) * z);
  delta.continuous.push_back(
      std::make_shared<BetweenSE2>(state(k - 1), state(k), z, Noise::isotropic(3, 0.02)));
  return delta;
}

TEST(WindowSmoother, WithAnInfiniteLagEqualsFullSmoothing) {
  std::mt19937 first(3), second(3);
  WindowSmoother window({WindowOptions::Mode::kFixedLag, 0});
  IncrementalSmoother full;
  for (int k = 0; k < 50; ++k) {
    window.update(step(k, first, window.smoother().values()));
    full.update(step(k, second, full.values()));
  }
  EXPECT_EQ(window.smoother().values().size(), full.values().size());
  EXPECT_DOUBLE_EQ(window.smoother().objective(), full.objective());
}

// On a chain the newest pose has the same marginal, whatever has left the window.
TEST(WindowSmoother, KeepsTheInformationOfWhatLeaves) {
  std::mt19937 first(11), second(11);
  WindowSmoother window({WindowOptions::Mode::kFixedLag, 5});
  IncrementalSmoother full;
  for (int k = 0; k < 120; ++k) {
    window.update(step(k, first, window.smoother().values()));
    full.update(step(k, second, full.values()));
    const Eigen::MatrixXd expected = full.joint_covariance({state(k)});
    EXPECT_LT((window.smoother().joint_covariance({state(k)}) - expected).norm(),
              1e-6 * expected.norm())
        << k;
  }
}

TEST(WindowSmoother, MemoryIsBounded) {
  std::mt19937 random(5);
  WindowSmoother window({WindowOptions::Mode::kFixedLag, 20});
  std::size_t early = 0;
  for (int k = 0; k < 2000; ++k) {
    const WindowReport report = window.update(step(k, random, window.smoother().values()));
    ASSERT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
    if (k == 200) early = window.smoother().memory().bytes;
  }
  EXPECT_LE(window.smoother().values().size(), 22u);
  EXPECT_LE(window.smoother().memory().bytes, early + early / 4);
}

/// A walk along x that sees landmark k with the next two poses, and names its class.
class Walk {
 public:
  explicit Walk(const WindowOptions& options) : window_(options) {}

  static Key landmark(int i) { return {'l', static_cast<std::uint64_t>(i)}; }
  static DiscreteKey class_of(int i) { return {Key('s', static_cast<std::uint64_t>(i)), 2}; }
  static HybridFactorPtr sighting(int k, int i, const Vector2d& offset) {
    return std::make_shared<WeightedFactor>(
        std::make_shared<Motion>(state(k), landmark(i), offset, 0.1),
        likelihood_table(class_of(i), {0.2, 0.8}));
  }

  /// The next pose, without sightings.
  Delta move() const {
    Delta delta;
    const Vector2d at(k_, 0.0);
    delta.values.insert(state(k_), at);
    if (k_ == 0) {
      delta.continuous.push_back(std::make_shared<Prior<Vector2d>>(state(0), at, Noise::unit(2)));
    } else {
      delta.continuous.push_back(
          std::make_shared<Motion>(state(k_ - 1), state(k_), Vector2d(1.0, 0.0), 0.3));
    }
    return delta;
  }
  Delta move_and_see() const {
    Delta delta = move();
    delta.values.insert(landmark(k_), Vector2d(k_ + 0.5, 0.9));
    delta.discrete.push_back(prior_table(class_of(k_), {0.5, 0.5}));
    delta.hybrid.push_back(sighting(k_, k_, {0.0, 1.0}));
    if (smoother().values().contains(landmark(k_ - 1))) {
      delta.hybrid.push_back(sighting(k_, k_ - 1, {-1.0, 1.0}));
    }
    return delta;
  }
  WindowReport take(const Delta& delta) {
    WindowReport report = window_.update(delta);
    EXPECT_EQ(report.status, UpdateReport::Status::kOk) << report.message;
    ++k_;
    return report;
  }

  const WindowSmoother& window() const { return window_; }
  const IncrementalSmoother& smoother() const { return window_.smoother(); }

 private:
  WindowSmoother window_;
  int k_ = 0;
};

/// How much likelier the second class is than the first, as a difference of costs.
double preference(const std::vector<const Table*>& tables) {
  double sum = 0.0;
  for (const Table* table : tables) sum += table->costs()[0] - table->costs()[1];
  return sum;
}

TEST(WindowSmoother, ClassesLeaveWithTheirLandmarksAndMemoryIsBounded) {
  Walk walk({WindowOptions::Mode::kFixedLag, 5});
  std::size_t early = 0;
  for (int k = 0; k < 1000; ++k) {
    walk.take(walk.move_and_see());
    if (k == 100) early = walk.smoother().memory().bytes;
  }
  EXPECT_LE(walk.smoother().assignment().size(), 8u);
  EXPECT_LE(walk.smoother().graph().discrete().size(), 16u);
  EXPECT_LE(walk.smoother().memory().bytes, early + early / 4);
  for (int i : {0, 500, 900}) {
    EXPECT_FALSE(walk.smoother().assignment().contains(Walk::class_of(i).key));
    EXPECT_EQ(walk.window().past().assignment.at(Walk::class_of(i).key), 1);
    const Table* table = walk.window().past_table(Walk::class_of(i).key);
    ASSERT_NE(table, nullptr);
    EXPECT_NEAR(preference({table}), 2 * std::log(4.0), 1e-9);
  }
}

TEST(WindowSmoother, WhatLeftEntersAgainWhenSeenAgain) {
  Walk walk({WindowOptions::Mode::kFixedLag, 4});
  for (int k = 0; k < 12; ++k) walk.take(walk.move_and_see());
  const Key position = Walk::landmark(2), label = Walk::class_of(2).key;
  ASSERT_TRUE(walk.window().past().values.contains(position));
  ASSERT_FALSE(walk.smoother().values().contains(position));

  Delta bad = walk.move();
  bad.hybrid.push_back(Walk::sighting(12, 2, {std::nan(""), 1.0}));
  EXPECT_THROW(walk.take(bad), Error);
  EXPECT_TRUE(walk.window().past().values.contains(position));
  EXPECT_NE(walk.window().past_table(label), nullptr);

  Delta again = walk.move();
  const Vector2d offset(2.25 - 12.0, 1.0);  // not where it was seen before
  again.hybrid.push_back(Walk::sighting(12, 2, offset));
  const WindowReport report = walk.take(again);
  ASSERT_EQ(report.handles.size(), 2u);  // those of the change, not what came back with it
  EXPECT_EQ(report.handles.hybrid.size(), 1u);
  EXPECT_FALSE(walk.window().past().values.contains(position));
  EXPECT_FALSE(walk.window().past().assignment.contains(label));
  EXPECT_EQ(walk.window().past_table(label), nullptr);
  // Where the new sighting puts it, with the class of all three.
  const Values& values = walk.smoother().values();
  EXPECT_LT((values.at<Vector2d>(position) - values.at<Vector2d>(state(12)) - offset).norm(), 1e-6);
  EXPECT_NEAR(preference(walk.smoother().component(label)), 3 * std::log(4.0), 1e-9);

  for (int k = 0; k < 6; ++k) walk.take(walk.move_and_see());
  EXPECT_TRUE(walk.window().past().values.contains(position));
  EXPECT_FALSE(walk.smoother().assignment().contains(label));
  ASSERT_NE(walk.window().past_table(label), nullptr);
  EXPECT_NEAR(preference({walk.window().past_table(label)}), 3 * std::log(4.0), 1e-9);
}

}  // namespace
}  // namespace hybrid
