// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "libhybrid/geometry/isometry.h"
#include "tests/libhybrid/landmarks/track_graph.h"

namespace hybrid {
namespace {

/// A sensor that sees all around to 10 m looked `times` times from the origin.
struct Looked {
  testing::TrackGraph world;
  Views views;

  explicit Looked(int times, double range_of_newest = 10) {
    for (int i = 0; i < times; ++i) look({0, 0});
    // The newest one, which is not in the map yet, counts for nothing.
    look({1000, 0}, range_of_newest);
    world.values.erase(Key('x', static_cast<std::uint64_t>(times)));
  }

  void look(const Eigen::Vector2d& from, double max_range = 10) {
    const Key pose('x', views.size());
    world.values.insert(pose, SE2(from.x(), from.y(), 0));
    DetectionFrame frame;
    frame.is_3d = false;
    frame.max_range = max_range;
    frame.fov_yaw = 2 * M_PI;
    SensorCoverage coverage;
    coverage.learn(frame);
    const std::vector<DetectionFrame> frames = {frame};
    const Eigen::Isometry3d T = to_isometry(SE2(from.x(), from.y(), 0));
    views.add({pose, T, frames}, Eigen::Isometry3d::Identity(), coverage, world.map());
  }

  double undetected(const Eigen::Vector2d& at, double sigma, double detected = 0.5) {
    return views.undetected(at, sigma * sigma * Eigen::Matrix2d::Identity(),
                            DetectionModel(detected), world.map());
  }
};

TEST(Views, WhereNobodyLookedAllIsUndetected) {
  EXPECT_NEAR(Looked(8).undetected({50, 0}, 0.1), 1.0, 1e-12);
  EXPECT_NEAR(Looked(0).undetected({2, 0}, 0.1), 1.0, 1e-12);
}

TEST(Views, TheFirstLookLeavesWhatADetectionMissesAndEveryOtherLookLess) {
  EXPECT_NEAR(Looked(1).undetected({2, 0}, 0.01, 0.7), 0.3, 1e-12);
  // A landmark that was missed once is likely to be one that is missed: more than 0.3^2 is left.
  const double second = Looked(2).undetected({2, 0}, 0.01, 0.7);
  EXPECT_GT(second, 0.09);
  EXPECT_LT(second, 0.3);
  EXPECT_LT(Looked(15).undetected({2, 0}, 0.01, 0.7), 0.01);
}

// Each look has the range of its own sensor, whichever has looked last.
TEST(Views, LooksOfASensorCountWhereAnotherSeesLessFar) {
  Looked two(8, 1);
  EXPECT_EQ(two.undetected({8.5, 0}, 0.1), Looked(8).undetected({8.5, 0}, 0.1));
  EXPECT_LT(two.undetected({8.5, 0}, 0.1), 0.2);
  std::vector<Key> even, odd;
  for (std::uint64_t i = 0; i < 8; ++i) (i % 2 == 0 ? even : odd).emplace_back('x', i);
  const auto evidence = [&](const Looked& looked) {
    return looked.views.one_rather_than_two({8.5, 0, 0}, even, {8.5, 0.1, 0}, odd,
                                            DetectionModel(0.5), looked.world.map());
  };
  EXPECT_EQ(evidence(two), evidence(Looked(8)));
  EXPECT_GT(evidence(two), 1);
  two.views.resize(8);
  EXPECT_EQ(two.views.reach(), 10);
}

TEST(Views, WhereItIsNotKnownWhetherAPlaceWasLookedAtTheMeanCounts) {
  const double known = Looked(15).undetected({7, 0}, 0.1);
  const double unsure = Looked(15).undetected({7, 0}, 3.0);
  EXPECT_LT(known, 0.01);
  EXPECT_GT(unsure, 0.1);  // one node in six of the axis to the border lies beyond it
  EXPECT_LT(unsure, 1.0);
}

TEST(Views, LooksThatLeftTheMapDoNotCount) {
  Looked looked(8);
  for (std::uint64_t i = 0; i < 8; ++i) looked.world.values.erase(Key('x', i));
  EXPECT_NEAR(looked.undetected({2, 0}, 0.1), 1.0, 1e-12);
}

/// Keys of the poses of every other look, from the first or the second on.
std::vector<Key> every_other(int first, int looks) {
  std::vector<Key> out;
  for (int i = first; i < looks; i += 2) out.emplace_back('x', static_cast<std::uint64_t>(i));
  return out;
}

double one_rather_than_two(const Looked& looked, const std::vector<Key>& a,
                           const std::vector<Key>& b, double y = 0) {
  return looked.views.one_rather_than_two({5, y, 0}, a, {5.1, y, 0}, b, DetectionModel(0.5),
                                          looked.world.map());
}

TEST(Views, LandmarksThatAreSeenInTurnsAreOne) {
  const Looked looked(20);
  const std::vector<Key> even = every_other(0, 20), odd = every_other(1, 20);
  EXPECT_GT(one_rather_than_two(looked, even, odd), std::log(100));
  EXPECT_NEAR(one_rather_than_two(looked, even, odd), one_rather_than_two(looked, odd, even), 1e-9);
  // Few looks say little.
  EXPECT_LT(one_rather_than_two(Looked(2), every_other(0, 2), every_other(1, 2)), std::log(10));
}

/// By hand: with a prior of five detections and five misses, two certain looks that both detect
/// have 5/10 6/11, one that does and one that does not 5/10 5/11.
TEST(Views, DetectionsAndMissesOfTwoLandmarksHaveTheirProbability) {
  EXPECT_NEAR(one_rather_than_two(Looked(2), every_other(0, 2), every_other(1, 2)),
              std::log(30.0 / 110) - 2 * std::log(25.0 / 110), 1e-9);
}

TEST(Views, WhatNoLookHadInViewSaysNothing) {
  const Looked looked(20);
  EXPECT_EQ(one_rather_than_two(looked, every_other(0, 20), every_other(1, 20), 50), 0);
  EXPECT_EQ(Views().one_rather_than_two({5, 0, 0}, {}, {5, 0, 0}, {}, DetectionModel(0.5),
                                        looked.world.map()),
            0);
}

}  // namespace
}  // namespace hybrid
