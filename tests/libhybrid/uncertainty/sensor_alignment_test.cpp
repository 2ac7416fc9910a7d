// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/sensor_alignment.h"

#include <gtest/gtest.h>

#include "tests/libhybrid/uncertainty/driven_world.h"

namespace hybrid {
namespace {

SensorAlignment align(const DrivenWorld& world) {
  const DrivenLog log = drive(world);
  return estimate_sensor_alignment(log.odometry, log.sightings());
}

TEST(SensorAlignment, NothingIsFoundWhereNothingIsWrong) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    DrivenWorld world;
    world.seed = seed;
    const SensorAlignment found = align(world);
    EXPECT_FALSE(found.is_significant) << seed << " " << found.yaw << " " << found.delay;
    EXPECT_EQ(found.unknown, "");
    EXPECT_LT(found.yaw_sigma, 0.03);
    EXPECT_LT(found.delay_sigma, 0.1);
  }
}

TEST(SensorAlignment, BearingsOfTheOtherSign) {
  DrivenWorld world;
  world.mirrored = -1;
  const SensorAlignment found = align(world);
  EXPECT_TRUE(found.mirrored);
  EXPECT_GT(found.mirror_sigmas, 5);
  EXPECT_NEAR(found.yaw, 0, 0.03);
}

TEST(SensorAlignment, ATurnedSensor) {
  for (const double yaw : {M_PI / 2, -0.2, 3.0}) {
    DrivenWorld world;
    world.yaw = yaw;
    const SensorAlignment found = align(world);
    EXPECT_TRUE(found.is_significant) << yaw;
    EXPECT_FALSE(found.mirrored);
    EXPECT_NEAR(std::remainder(found.yaw - yaw, 2 * M_PI), 0, 0.03) << yaw;
  }
}

TEST(SensorAlignment, ADelayedClock) {
  for (const double delay : {0.5, -0.3}) {
    DrivenWorld world;
    world.delay = delay;
    const SensorAlignment found = align(world);
    EXPECT_TRUE(found.is_significant) << delay;
    EXPECT_NEAR(found.delay, delay, 0.05);
    EXPECT_NEAR(found.yaw, 0, 0.03);
  }
}

TEST(SensorAlignment, ADelayOfARobotThatTurnsAlikeForMostOfTheTime) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    DrivenWorld world;
    world.seed = seed;
    world.bends_rarely = true;
    world.delay = 0.5;
    const SensorAlignment found = align(world);
    EXPECT_TRUE(found.is_significant) << seed;
    EXPECT_NEAR(found.delay, 0.5, 0.1);
  }
}

TEST(SensorAlignment, WhatARobotDoesNotDoItCannotTell) {
  DrivenWorld world;
  world.speed = world.turning = world.odometry_angle = 0;
  world.mirrored = -1;
  EXPECT_FALSE(align(world).is_significant);
  EXPECT_NE(align(world).unknown, "");
  world.speed = 0.2;  // straight on
  EXPECT_FALSE(align(world).mirrored && align(world).delay != 0);
  EXPECT_NE(align(world).unknown, "");
  EXPECT_NE(estimate_sensor_alignment({}, {}).unknown, "");
}

}  // namespace
}  // namespace hybrid
