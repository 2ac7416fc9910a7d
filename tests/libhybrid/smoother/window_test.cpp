// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/smoother/window.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <memory>
#include <random>

#include "libhybrid/factors/between.h"
#include "libhybrid/factors/factor_of.h"
#include "libhybrid/factors/prior.h"

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

}  // namespace
}  // namespace hybrid
