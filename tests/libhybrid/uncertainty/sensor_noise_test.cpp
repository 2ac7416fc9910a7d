// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/sensor_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

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
