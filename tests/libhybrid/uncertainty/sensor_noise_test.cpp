// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/sensor_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/libhybrid/uncertainty/driven_world.h"

namespace hybrid {
namespace {

SensorNoise measure(const DrivenWorld& world) {
  return measure_sensor_noise(drive(world).frames);
}

TEST(SensorNoise, IsFoundWhateverIsStated) {
  for (const double stated : {0.005, 0.05, 0.5}) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      DrivenWorld world;
      world.stated_range = stated;
      world.stated_angle = stated / 10;
      world.seed = seed;
      const SensorNoise noise = measure(world);
      ASSERT_EQ(noise.unknown, "") << stated << " " << seed;
      EXPECT_NEAR(noise.range.value, world.range_m, 0.15 * world.range_m);
      EXPECT_NEAR(noise.angle.value, world.angle, 0.15 * world.angle);
      EXPECT_TRUE(noise.range.is_sure());
      EXPECT_TRUE(noise.angle.is_sure());
      EXPECT_NEAR(noise.stated_range, stated, 1e-9 * stated);
      EXPECT_GT(noise.pairs, 500U);
    }
  }
}

TEST(SensorNoise, AShareOfTheRangeIsToldFromAConstant) {
  DrivenWorld world;
  world.range_m = 0;
  world.range_share = 0.03;
  const SensorNoise noise = measure(world);
  ASSERT_FALSE(noise.is_scaled);
  EXPECT_NEAR(noise.range_share, 0.03, 0.005);
  EXPECT_LT(noise.range_m, 0.1);
  EXPECT_NEAR(noise.range.value, 0.03 * noise.at_range, 0.004 * noise.at_range);
}

TEST(SensorNoise, InSpace) {
  DrivenWorld world;
  world.is_3d = true;
  const SensorNoise noise = measure(world);
  EXPECT_NEAR(noise.range.value, world.range_m, 0.15 * world.range_m);
  EXPECT_NEAR(noise.angle.value, world.angle, 0.15 * world.angle);
}

TEST(SensorNoise, OdometryTenTimesTooSureOrTooUnsureShows) {
  for (const double factor : {0.1, 1.0, 10.0}) {
    DrivenWorld world;
    world.odometry_angle = 0.02;
    world.stated_odometry_angle = factor * world.odometry_angle;
    const SensorNoise noise = measure(world);
    ASSERT_TRUE(noise.rotation.replaces(1)) << factor << " " << noise.rotation.sigma;
    EXPECT_NEAR(noise.rotation.value * factor, 1, 0.35);
  }
}

TEST(SensorNoise, ClutterAndMissesDoNotCount) {
  DrivenWorld world;
  world.clutter = 0.9;
  const SensorNoise noise = measure(world);
  EXPECT_NEAR(noise.range.value, world.range_m, 0.2 * world.range_m);
  EXPECT_NEAR(noise.angle.value, world.angle, 0.2 * world.angle);
}

TEST(SensorNoise, ErrorsThatLastShowInPairsFartherApart) {
  DrivenWorld world;
  world.things = 200;  // enough in view for many pairs
  EXPECT_TRUE(measure(world).is_white());
  world.lasting = 0.2;
  const SensorNoise noise = measure(world);
  EXPECT_FALSE(noise.is_white());
  EXPECT_GT(noise.lags.back().range, 1.5);
  EXPECT_LT(noise.lags.back().angle, noise.lags.back().range);  // in the ranges they are
}

// What lasts counts with its full size, and in what it is of alone.
TEST(SensorNoise, ThatLastsIsMeasuredWhole) {
  double range = 0, angle = 0;
  constexpr int kSeeds = 3;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    DrivenWorld world;
    world.things = 200;
    world.range_m = 0.02;
    world.lasting = 0.1;
    world.stated_range = 0.07;
    world.stated_angle = 0.01;
    world.seed = seed;
    const SensorNoise noise = measure(world);
    range += noise.range.value / kSeeds;
    angle += noise.angle.value / kSeeds;
  }
  EXPECT_NEAR(range, 0.102, 0.02);
  EXPECT_NEAR(angle, 0.01, 0.002);
}

TEST(SensorNoise, SaysWhereTheLogCannotTell) {
  EXPECT_NE(measure_sensor_noise({}).unknown, "");
  DrivenWorld world;
  world.frames = 1;
  EXPECT_NE(measure(world).unknown, "");
  world = {};
  world.things = 0;
  world.clutter = 1;  // one false detection in each frame
  EXPECT_FALSE(measure(world).range.is_sure() && measure(world).unknown.empty());
}

// A thousand things in a square metre: nobody can tell which is which, and it ends soon.
TEST(SensorNoise, ThingsTooCloseTogetherToTell) {
  DrivenWorld world;
  world.things = 1000;
  world.half = 0.5;
  world.frames = 100;
  world.speed = 0.1;
  DrivenLog log = drive(world);
  const SensorNoise noise = measure_sensor_noise(log.frames);
  EXPECT_NE(noise.unknown, "");
}

/// A dense log: a robot that rests and then drives among things whose ranges are off by where they
/// are seen from.
std::vector<MovedSightings> rest_and_drive(int resting, int driving, double by_viewpoint) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-12, 12);
  std::vector<Eigen::Vector3d> things;
  for (int i = 0; i < 60; ++i) things.emplace_back(uniform(random), uniform(random), 0);
  std::vector<MovedSightings> out;
  SE3 pose;
  for (int i = 0; i < resting + driving; ++i) {
    const double turn = 0.03 + 0.05 * std::sin(0.05 * i);
    if (i >= resting) pose = pose * SE3({0.2, 0, 0}, SO3::exp({0, 0, turn}));
    MovedSightings frame;
    frame.sightings.time = 0.2 * i;
    frame.T_odometry_robot = pose;
    frame.motion_covariance(0, 0) = frame.motion_covariance(1, 1) = 1e-6;
    frame.motion_covariance(5, 5) = 1e-8;
    for (const Eigen::Vector3d& p : things) {
      const Eigen::Vector3d away = pose.translation() - p;
      const double direction = std::atan2(away.y(), away.x());
      Eigen::Vector3d z = to_polar(Eigen::Vector3d(pose.inverse() * p));
      z[0] +=
          by_viewpoint * std::sqrt(2.0) * std::sin(2 * direction + p.x()) + 0.02 * normal(random);
      z[1] += 0.005 * normal(random);
      if (z[0] < 0.5) continue;
      frame.sightings.seen.push_back({z.head(2), Eigen::Vector2d(0.04, 1e-4).asDiagonal()});
      frame.ids.emplace_back();
    }
    out.push_back(std::move(frame));
  }
  return out;
}

// While a robot rests, what depends on where a thing is seen from stays the same.
TEST(SensorNoise, IsThatOfARobotThatMovesHoweverLongItRests) {
  for (const int resting : {0, 300}) {
    const SensorNoise noise = measure_sensor_noise(rest_and_drive(resting, 300, 0.3));
    ASSERT_EQ(noise.unknown, "");
    EXPECT_FALSE(noise.is_white()) << resting;  // and so replaces nothing that is larger
  }
  const SensorNoise noise = measure_sensor_noise(rest_and_drive(300, 300, 0));
  EXPECT_TRUE(noise.is_white());
  EXPECT_NEAR(noise.range.value, 0.02, 0.003);
}

TEST(SensorNoise, ARobotAtRestAndNoiseOfZeroStated) {
  DrivenWorld world;
  world.speed = world.turning = 0;
  world.stated_range = world.stated_angle = 0;
  const SensorNoise noise = measure(world);
  EXPECT_NEAR(noise.range.value, world.range_m, 0.15 * world.range_m);
  EXPECT_FALSE(noise.is_scaled);
}

}  // namespace
}  // namespace hybrid
