// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/clouds/pose_preference.h"

#include <gtest/gtest.h>

#include "tests/support/cloud_worlds.h"

namespace hybrid {
namespace {

constexpr double kSpacing = 0.2, kBlock = 1;

/// A map of some clouds of a world, and one more cloud.
struct Scene {
  Scene(const testing::CloudWorld& world, const SE3& pose) {
    std::mt19937 random(1);
    for (const double x : {-1.0, -0.5, 0.0}) {
      const SE3 from({x, 0, 0}, SO3());
      map.add(transformed(from, seen(world, from, random)));
    }
    coarse.add(map.points());
    points = seen(world, pose, random);
  }
  static std::vector<CloudPoint> seen(const testing::CloudWorld& world, const SE3& pose,
                                      std::mt19937& random) {
    return cloud_points(testing::cloud_at(world, pose, random), Eigen::Vector3f::Zero(), kSpacing);
  }
  double prefers(const SE3& a, const SE3& b) const {
    return preference(points, map, coarse, a, b, kBlock);
  }

  CloudSurfaces map{kSpacing}, coarse{3 * kSpacing};
  std::vector<CloudPoint> points;
};

const SE3 kTruth({0.5, 0, 0}, SO3());

TEST(PosePreference, IsForWhereTheCloudWasSeen) {
  const Scene scene(testing::cluttered_hall(), kTruth);
  for (const double off : {-1.0, -0.4, 0.4, 1.0}) {
    const SE3 other({0.5 + off, 0, 0}, SO3());
    EXPECT_GT(scene.prefers(other, kTruth), 25) << off;
    EXPECT_NEAR(scene.prefers(other, kTruth), -scene.prefers(kTruth, other), 1e-9);
  }
  EXPECT_EQ(scene.prefers(kTruth, kTruth), 0);
}

TEST(PosePreference, IsNoneAlongATunnel) {
  const Scene scene({{{-500, -3, -1}, {500, 3, 3}}, {}}, kTruth);
  for (const double off : {-1.0, -0.4, 0.4, 1.0}) {
    EXPECT_LT(std::abs(scene.prefers({{0.5 + off, 0, 0}, SO3()}, kTruth)), 25) << off;
  }
}

TEST(PosePreference, WhatIsSeenForTheFirstTimeTellsNothing) {
  const Scene scene(testing::cluttered_hall(), kTruth);
  const CloudSurfaces none(kSpacing);
  EXPECT_EQ(preference(scene.points, scene.map, none, SE3(), kTruth, kBlock), 0);
  EXPECT_EQ(preference({}, scene.map, scene.coarse, SE3(), kTruth, kBlock), 0);
}

}  // namespace
}  // namespace hybrid
