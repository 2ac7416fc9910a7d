// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include <gtest/gtest.h>

#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/calibrated_bearing_range.h"
#include "libhybrid/factors/calibrated_motion.h"
#include "libhybrid/factors/expect_jacobians.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/factors/steady_motion.h"
#include "libhybrid/solvers/levenberg_marquardt.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::expect_jacobians;
using testing::expect_robust_gradient;
using testing::Random;

const Key kA{'x', 0}, kB{'x', 1}, kPoint{'l', 0}, kSensor{'c', 0}, kOdometry{'o', 0};

template <class Pose>
void check_sighting() {
  using Point = typename Pose::Point;
  constexpr int kDim = Point::RowsAtCompileTime;
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    Values values;
    values.insert(kA, random.value<Pose>());
    values.insert(kPoint, random.value<Point>(4.0));
    values.insert(kSensor, random.value<Pose>());
    Point z = random.vector<kDim>();
    z[0] = random.uniform(1.0, 5.0);
    const Noise noise = random.noise(kDim);
    const CalibratedBearingRange<Pose> factor(kA, kPoint, kSensor, z, noise);
    expect_jacobians(factor, values, 1e-5);
    expect_robust_gradient(
        CalibratedBearingRange<Pose>(kA, kPoint, kSensor, z, noise, Loss::cauchy()), values, 1e-5);
    const BearingRange<Pose> fixed(kA, kPoint, z, noise, values.at<Pose>(kSensor));
    EXPECT_NEAR(factor.cost(values), fixed.cost(values), 1e-9);
  }
  EXPECT_THROW(CalibratedBearingRange<Pose>(kA, kPoint, kSensor, -Point::Ones(), Noise::unit(kDim)),
               Error);
}

TEST(CalibratedBearingRange, JacobiansAndCost) {
  check_sighting<SE2>();
  check_sighting<SE3>();
}

template <class Pose, class Calibration, class Factor, class Plain>
void check_motion() {
  Random random(2);
  for (int trial = 0; trial < 20; ++trial) {
    Calibration c = random.vector<Calibration::RowsAtCompileTime>(0.1);
    c.template head<2>() += Eigen::Vector2d::Ones();
    Values values;
    values.insert(kA, random.value<Pose>());
    values.insert(kB, random.value<Pose>());
    values.insert(kOdometry, c);
    const Pose z = random.value<Pose>();
    const Noise noise = random.noise(Pose::kDim);
    expect_jacobians(Factor(kA, kB, kOdometry, z, noise), values, 1e-5);
    expect_robust_gradient(Factor(kA, kB, kOdometry, z, noise, Loss::cauchy()), values, 1e-5);
    Calibration none = Calibration::Zero();
    none.template head<2>().setOnes();
    values.update(kOdometry, none);
    EXPECT_NEAR(Factor(kA, kB, kOdometry, z, noise).cost(values),
                Plain(kA, kB, z, noise).cost(values), 1e-9);
  }
}

TEST(CalibratedMotion, JacobiansAndCost) {
  check_motion<SE2, OdometryCalibration2, CalibratedMotion2, BetweenSE2>();
  check_motion<SE3, OdometryCalibration3, CalibratedMotion3, Between<SE3>>();
}

template <class Pose>
void check_steady() {
  Random random(4);
  constexpr int kDim = Pose::Point::RowsAtCompileTime;
  for (int trial = 0; trial < 20; ++trial) {
    Values values;
    for (int i = 0; i < 3; ++i) values.insert(Key('x', i), random.value<Pose>());
    const Noise noise = random.noise(kDim);
    expect_jacobians(SteadyMotion<Pose>(Key('x', 0), Key('x', 1), Key('x', 2), noise), values,
                     1e-5);
  }
  const Pose step = random.value<Pose>();
  Values values;
  values.insert(Key('x', 0), random.value<Pose>());
  values.insert(Key('x', 1), values.at<Pose>(Key('x', 0)) * step);
  values.insert(Key('x', 2), values.at<Pose>(Key('x', 1)) * step);
  const SteadyMotion<Pose> factor(Key('x', 0), Key('x', 1), Key('x', 2), Noise::unit(kDim));
  EXPECT_NEAR(factor.cost(values), 0.0, 1e-20);
}

TEST(SteadyMotion, JacobiansAndZeroAtASteadyStep) {
  check_steady<SE2>();
  check_steady<SE3>();
}

TEST(CalibratedMotion, ScaleAndDriftAreRecoveredFromPositions) {
  Random random(3);
  const OdometryCalibration2 truth(1.1, 0.9, 0.05);
  HybridGraph graph;
  Estimate start;
  SE2 T;
  start.values.insert(kOdometry, OdometryCalibration2(1.0, 1.0, 0.0));
  for (int i = 0; i < 40; ++i) {
    graph.emplace<Prior<SE2>>(Key('x', i), T, Noise::isotropic(3, 0.01));
    start.values.insert(Key('x', i), T);
    if (i == 39) break;
    const SE2 measured(random.uniform(0.1, 0.5), 0.0, random.normal(0.3));
    graph.emplace<CalibratedMotion2>(Key('x', i), Key('x', i + 1), kOdometry, measured,
                                     Noise::isotropic(3, 0.01));
    T = T * calibrated(measured, truth);
  }
  const SolverResult result = levenberg_marquardt(graph, start);
  EXPECT_LT((result.values.at<OdometryCalibration2>(kOdometry) - truth).norm(), 1e-6);
}

}  // namespace
}  // namespace hybrid
