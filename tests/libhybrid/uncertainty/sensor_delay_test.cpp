// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/sensor_delay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "libhybrid/geometry/polar.h"

namespace hybrid {
namespace {

struct DelayedLog {
  std::vector<OdometryPose> odometry;
  std::vector<TimedSightings> sightings;
};

/// A robot among landmarks that turns another way every second (unless `swing` is 0 [rad/s]), and a
/// sensor of 4 frames a second whose sightings come `delay` late.
DelayedLog drive(double delay, double swing, bool is_3d, unsigned seed) {
  constexpr double kOdometryStep = 0.05, kFrameStep = 0.25, kEnd = 120;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1, 1);
  DelayedLog log;
  SE3 pose;
  SE3::Tangent velocity = SE3::Tangent::Zero();
  velocity[0] = 0.5;
  for (int i = 0; kOdometryStep * i <= kEnd; ++i) {
    log.odometry.push_back({kOdometryStep * i, pose});
    if (i % 20 == 0) velocity[5] = swing * uniform(random);
    if (i % 20 == 0 && is_3d) velocity[4] = swing * uniform(random);
    pose = pose * SE3::exp(kOdometryStep * velocity);
  }
  std::vector<Eigen::Vector3d> landmarks;
  for (int k = 0; k < 40; ++k) {
    landmarks.emplace_back(20 * uniform(random), 20 * uniform(random),
                           is_3d ? 20 * uniform(random) : 0.0);
  }
  const SE3 T_robot_sensor({0.3, 0.1, 0}, SO3());
  const Eigen::Vector3d sigmas(0.05, 0.01, 0.01);
  const int dim = is_3d ? 3 : 2;
  for (double time = 2; time < kEnd - 2; time += kFrameStep) {
    TimedSightings frame{time, T_robot_sensor, {}};
    const auto step = static_cast<std::size_t>(std::lround((time - delay) / kOdometryStep));
    const SE3 sensor = log.odometry[step].pose * T_robot_sensor;
    for (const Eigen::Vector3d& landmark : landmarks) {
      Eigen::Vector3d z = to_polar(Eigen::Vector3d(sensor.inverse() * landmark));
      if (z[0] > 10 || std::abs(z[1]) > 1.0) continue;
      for (int k = 0; k < dim; ++k) z[k] += sigmas[k] * normal(random);
      const Eigen::VectorXd variances = sigmas.head(dim).array().square();
      frame.seen.push_back({z.head(dim), variances.asDiagonal()});
    }
    log.sightings.push_back(frame);
  }
  return log;
}

TEST(SensorDelay, FindsADelayEitherWayAndNoneWhereThereIsNone) {
  for (const bool is_3d : {false, true}) {
    for (const double planted : {0.3, -0.2, 0.0}) {
      for (unsigned seed = 1; seed <= 3; ++seed) {
        const DelayedLog log = drive(planted, 1.0, is_3d, seed);
        const SensorDelay found = estimate_sensor_delay(log.odometry, log.sightings);
        EXPECT_NEAR(found.seconds, planted, 0.02) << is_3d << planted << seed;
        EXPECT_LT(found.sigma, 0.02);
        EXPECT_EQ(found.is_significant(), planted != 0) << found.seconds << " " << found.sigma;
      }
    }
  }
}

// Where the velocity never changes, what is seen looks the same at any delay.
TEST(SensorDelay, AStraightWayDoesNotTellIt) {
  const DelayedLog log = drive(0.3, 0, false, 1);
  EXPECT_FALSE(estimate_sensor_delay(log.odometry, log.sightings).is_significant());
}

TEST(SensorDelay, NothingSeenTellsNothing) {
  DelayedLog log = drive(0.3, 1, false, 1);
  EXPECT_FALSE(estimate_sensor_delay({}, log.sightings).is_significant());
  EXPECT_FALSE(estimate_sensor_delay(log.odometry, {}).is_significant());
  for (TimedSightings& frame : log.sightings) frame.seen.clear();
  const SensorDelay none = estimate_sensor_delay(log.odometry, log.sightings);
  EXPECT_FALSE(none.is_significant());
  EXPECT_TRUE(std::isinf(none.sigma));
  EXPECT_EQ(none.seconds, 0);
}

}  // namespace
}  // namespace hybrid
