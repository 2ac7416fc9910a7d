// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/reassociation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "tests/libhybrid/landmarks/track_graph.h"

namespace hybrid {
namespace {

using testing::kCar;
using testing::kTree;

/// Two trees that were seen five times each, from poses at the origin.
struct TwoTrees {
  testing::TrackGraph world;
  AssociationOptions options;
  std::map<std::string, SensorCoverage> coverage;
  std::map<std::int64_t, int> track_of_id;
  int near = -1, far = -1;

  TwoTrees() {
    near = world.landmark({10, 0}, kTree, 5);
    far = world.landmark({10, 2}, kTree, 5);
    for (const int t : {near, far}) world.tracks.track(t).existence = 3;
    DetectionFrame frame;
    frame.is_3d = false;
    frame.max_range = 30;
    frame.fov_yaw = 2 * M_PI;
    coverage[""].learn(frame);
  }
  int see_as(int track, const Eigen::Vector2d& point, const std::vector<double>& scores = kTree) {
    Contribution out;
    const int s = world.see(point, scores);
    if (track >= 0) world.tracks.attach(s, track, false, out);
    world.apply(out);
    return s;
  }
  std::vector<Reassignment> reassociate() {
    for (int i = 1; i <= world.frames; ++i) {
      const Key pose(key_letter::kPose, static_cast<std::uint64_t>(i));
      if (!world.values.contains(pose)) world.values.insert(pose, SE2());
    }
    return hybrid::reassociate(world.map(), world.classes, coverage, options, track_of_id,
                               world.tracks);
  }
  /// One that the sensor names 7, which is the near tree.
  int see_named(int track, const Eigen::Vector2d& point) {
    track_of_id[7] = near;
    const int s = see_as(track, point);
    world.tracks.sighting(s).detection.id = 7;
    return s;
  }
};

TEST(Reassociation, WhatIsRightStays) {
  TwoTrees trees;
  trees.see_as(trees.near, {10.05, 0.02});
  EXPECT_TRUE(trees.reassociate().empty());
}

TEST(Reassociation, ASightingOfTheOtherLandmarkGoesThere) {
  TwoTrees trees;
  const int s = trees.see_as(trees.near, {10, 1.9});
  const auto changes = trees.reassociate();
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].sighting, s);
  EXPECT_EQ(changes[0].track, trees.far);
}

TEST(Reassociation, OneThatFitsNoLandmarkIsClutterAndOneTakenForClutterMayBeALandmark) {
  TwoTrees trees;
  const int wrong = trees.see_as(trees.near, {10, -6});
  const int right = trees.see_as(-1, {10.02, 0});
  const auto changes = trees.reassociate();
  ASSERT_EQ(changes.size(), 2U);
  EXPECT_EQ(changes[0].sighting, wrong);
  EXPECT_EQ(changes[0].track, -1);
  EXPECT_EQ(changes[1].sighting, right);
  EXPECT_EQ(changes[1].track, trees.near);
}

TEST(Reassociation, TwoOfOneFrameAreTwoLandmarks) {
  TwoTrees trees;
  Contribution out;
  const int a = trees.world.see({10, 0.9}, kTree),
            b = trees.world.see({10, 0.1}, kTree, trees.world.frames);
  trees.world.tracks.attach(a, trees.near, false, out);
  trees.world.tracks.attach(b, trees.far, false, out);
  trees.world.apply(out);
  std::map<int, int> now;
  for (const auto& [s, t] : trees.reassociate()) now[s] = t;
  EXPECT_EQ(now, (std::map<int, int>{{a, -1}, {b, trees.near}}));
}

TEST(Reassociation, ATentativeLandmarkTakesNoSightings) {
  TwoTrees trees;
  const int tentative = trees.world.landmark({-10, 0}, kTree);
  trees.world.tracks.track(tentative).existence = 3;
  trees.see_as(-1, {-10, 0.05});
  EXPECT_TRUE(trees.reassociate().empty());
  trees.options.confirm = 1;
  EXPECT_EQ(trees.reassociate().size(), 1U);
}

TEST(Reassociation, WhatTheLogNamesIsOfItsLandmarkThoughAnotherIsNearer) {
  TwoTrees trees;
  trees.world.tracks.track(trees.far).alive = false;
  trees.far = trees.world.landmark({10, 0.3}, kTree, 5);
  trees.world.tracks.track(trees.far).existence = 3;
  trees.see_named(trees.near, {10, 0.25});
  EXPECT_TRUE(trees.reassociate().empty());
  trees.options.use_ids = false;
  ASSERT_EQ(trees.reassociate().size(), 1U);
  EXPECT_EQ(trees.reassociate()[0].track, trees.far);
}

TEST(Reassociation, AnIdThatTheSensorMisreadIsClutter) {
  TwoTrees trees;
  const int s = trees.see_named(trees.near, {10, 1.9});
  const auto changes = trees.reassociate();
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].sighting, s);
  EXPECT_EQ(changes[0].track, -1);
}

TEST(Reassociation, WhatWasTakenForMisreadGoesBackToTheLandmarkThatItNames) {
  TwoTrees trees;
  const int s = trees.see_named(-1, {10, 0.05});
  const auto changes = trees.reassociate();
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].sighting, s);
  EXPECT_EQ(changes[0].track, trees.near);
  trees.world.tracks.track(trees.near).alive = false;
  EXPECT_TRUE(trees.reassociate().empty());
}

TEST(Reassociation, AClassThatDoesNotFitCounts) {
  TwoTrees trees;
  const int between = trees.see_as(trees.near, {10, 0.3}, kTree);
  const int car = trees.world.landmark({10, 0.55}, kCar, 8);
  trees.world.tracks.track(car).existence = 3;
  EXPECT_TRUE(trees.reassociate().empty());  // nearer to the car, and a tree
  trees.world.tracks.sighting(between).phi = kCar;
  const auto changes = trees.reassociate();
  ASSERT_EQ(changes.size(), 1U);
  EXPECT_EQ(changes[0].track, car);
}

}  // namespace
}  // namespace hybrid
