// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors
#include "libhybrid/uncertainty/sensor_alignment.h"

#include <gtest/gtest.h>

#include <random>

#include "libhybrid/geometry/polar.h"
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

SensorAlignment align_in_units(const DrivenWorld& world, double metre) {
  const DrivenLog log = drive(world);
  std::vector<TimedSightings> sightings = log.sightings();
  for (TimedSightings& frame : sightings) {
    for (MeasuredPoint& seen : frame.seen) seen.z[0] *= metre;
  }
  return estimate_sensor_alignment(log.odometry, sightings);
}

TEST(SensorAlignment, RangesOfAnotherUnit) {
  for (const double metre : {1 / 0.3048, 0.3048, 1 / 0.0254, 100.0}) {
    for (unsigned seed = 1; seed <= 3; ++seed) {
      DrivenWorld world;
      world.seed = seed;
      world.mirrored = seed == 3 ? -1 : 1;
      EXPECT_NEAR(metre * align_in_units(world, metre).length, 1, 1e-9) << metre << " " << seed;
    }
  }
}

TEST(SensorAlignment, MetresAreNoOtherUnit) {
  const auto kinds = {+[](DrivenWorld&) {},
                      +[](DrivenWorld& w) { w.turning = 0; },
                      +[](DrivenWorld& w) { w.speed = 0.1; },
                      +[](DrivenWorld& w) { w.range_m = 0.5; },
                      +[](DrivenWorld& w) { w.things = 200; },
                      +[](DrivenWorld& w) { w.things = 5; },
                      +[](DrivenWorld& w) { w.delay = 0.5; },
                      +[](DrivenWorld& w) { w.clutter = 3; },
                      +[](DrivenWorld& w) { w.frames = 80; }};
  for (const auto& change : kinds) {
    for (unsigned seed = 1; seed <= 5; ++seed) {
      DrivenWorld world;
      world.seed = seed;
      change(world);
      EXPECT_EQ(align(world).length, 1) << (&change - kinds.begin()) << " " << seed;
    }
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

/// A robot on a circle whose camera, turned by `yaw`, mostly sees one thing at a time.
SensorAlignment align_on_circle(unsigned seed, double yaw) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Eigen::Vector3d> things;
  for (int i = 0; i < 7; ++i) {
    const double angle = M_PI * uniform(random), radius = 7 + 3 * uniform(random);
    things.emplace_back(radius * std::cos(angle), 5 + radius * std::sin(angle), 0);
  }
  const SE3 turn(Eigen::Vector3d::Zero(), SO3::exp({0, 0, yaw}));
  const Eigen::Vector2d variances(0.65 * 0.65, 0.02 * 0.02);  // as of boxes; ranges are far better
  std::vector<OdometryPose> odometry;
  std::vector<TimedSightings> sightings;
  SE3 pose, measured;
  for (int i = 0; i < 790; ++i) {
    odometry.push_back({0.1 * i, measured});
    if (i % 5 == 0) sightings.push_back({0.1 * i, SE3(), {}});
    for (const Eigen::Vector3d& thing : things) {
      const Eigen::Vector3d z = to_polar(Eigen::Vector3d((pose * turn).inverse() * thing));
      if (i % 5 != 0 || z[0] > 9 || std::abs(z[1] + yaw) > 0.49) continue;
      const Eigen::Vector2d noisy(z[0] + 0.08 * normal(random), z[1] + 0.02 * normal(random));
      sightings.back().seen.push_back({noisy, variances.asDiagonal()});
    }
    SE3::Tangent step = SE3::Tangent::Zero();
    step[0] = 0.08;
    step[5] = 0.016;
    pose = pose * SE3::exp(step);
    step[0] *= 1 + 0.02 * normal(random);
    step[5] += 0.0028 * normal(random);
    measured = measured * SE3::exp(step);
  }
  return estimate_sensor_alignment(odometry, sightings);
}

/// Over worlds of a kind: errors by their standard deviations, root mean squares.
struct Errors {
  double yaw = 0, delay = 0;
};

Errors errors_of(DrivenWorld world) {
  constexpr int kSeeds = 20;
  Errors squares;
  int told = 0;
  for (unsigned seed = 1; seed <= kSeeds; ++seed) {
    world.seed = seed;
    const SensorAlignment found = align(world);
    if (!found.is_significant) continue;
    ++told;
    squares.yaw += std::pow(std::remainder(found.yaw - world.yaw, 2 * M_PI) / found.yaw_sigma, 2);
    squares.delay += std::pow((found.delay - world.delay) / found.delay_sigma, 2);
  }
  EXPECT_GE(told, kSeeds - 1);
  return {std::sqrt(squares.yaw / told), std::sqrt(squares.delay / told)};
}

/// Over 20 worlds, a standard deviation that is right gives .7 to 1.4.
void expect_right(double error) {
  EXPECT_GT(error, 0.6);
  EXPECT_LT(error, 1.5);
}

TEST(SensorAlignment, YawAndDelayAreAsSureAsTheySay) {
  DrivenWorld turned;
  turned.yaw = 0.1;
  expect_right(errors_of(turned).yaw);
  turned.lasting = 0.2;
  expect_right(errors_of(turned).yaw);

  DrivenWorld all;
  all.mirrored = -1;
  all.yaw = 0.3;
  all.delay = 0.15;
  const Errors errors = errors_of(all);
  expect_right(errors.yaw);
  expect_right(errors.delay);

  DrivenWorld noisy;  // three times the angle, four times the range
  noisy.yaw = 0.15;
  noisy.angle = 0.03;
  noisy.range_m = 0.2;
  expect_right(errors_of(noisy).yaw);

  DrivenWorld bends;  // a delay that a sixth of the log tells
  bends.delay = 0.5;
  bends.bends_rarely = true;
  expect_right(errors_of(bends).delay);
}

TEST(SensorAlignment, ASlowTurnOfTheOdometryIsNoYaw) {
  int found = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    EXPECT_FALSE(align_on_circle(seed, 0).is_significant) << seed;
    const SensorAlignment turned = align_on_circle(seed, 0.3);
    if (turned.is_significant && std::abs(turned.yaw - 0.3) < 0.12) ++found;
  }
  EXPECT_GE(found, 40);
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
