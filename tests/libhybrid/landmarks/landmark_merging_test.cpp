// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/landmark_merging.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tests/libhybrid/landmarks/track_graph.h"

namespace hybrid {
namespace {

using testing::kCar;
using testing::kTree;
using testing::TrackGraph;

constexpr double kDensity = 0.01;  // landmarks per m^2

/// Two landmarks, the second `apart` from the first, and what is proposed about them.
struct Two {
  TrackGraph world;
  AssociationOptions options;
  LandmarkMerging merging{options};
  int a, b;

  explicit Two(const Eigen::Vector2d& apart, const std::vector<double>& class_of_second = kTree)
      : a(world.landmark({10, 0}, kTree, 4)),
        b(world.landmark(Eigen::Vector2d(10, 0) + apart, class_of_second, 4)) {
    saw(a);
    saw(b);
  }
  void saw(int t) { merging.sighted(t, 1, world.tracks.track(t).sightings.size()); }
  Merge propose() {
    return merging.propose(world.map(), world.classes, kDensity, 1, false, world.tracks);
  }
};

TEST(LandmarkMerging, TwoAtOnePlaceAreOne) {
  Two two({0.1, 0.05});
  const Merge merge = two.propose();
  ASSERT_EQ(merge.pairs.size(), 1U);
  EXPECT_EQ(merge.pairs[0], std::make_pair(two.b, two.a));
  EXPECT_GT(merge.allowed_rise(), 0);
}

// Frames stay open between two that are one for as long as they are two.
TEST(LandmarkMerging, TwoBetweenWhichAFrameIsOpenMayBeOne) {
  Two two({0.1, 0.05});
  two.world.tracks.track(two.a).open = 1;
  two.world.tracks.track(two.b).open = 1;
  EXPECT_EQ(two.propose().pairs.size(), 1U);
}

// To propose changes nothing: what is noted of it decides whether it is worth to ask again.
TEST(LandmarkMerging, AsksAgainOnceThereIsNews) {
  Two two({0.1, 0.05});
  const LandmarkMerging& asked = two.merging;
  const auto propose = [&](int keyframe) {
    return asked.propose(two.world.map(), two.world.classes, kDensity, keyframe, false,
                         two.world.tracks);
  };
  EXPECT_EQ(propose(1).pairs.size(), 1U);
  EXPECT_EQ(propose(1).pairs.size(), 1U);
  EXPECT_TRUE(propose(1 + two.options.recent + 1).pairs.empty());  // not recent any more
  two.merging.note(Merge());
  EXPECT_TRUE(propose(1).pairs.empty());
  two.merging.remember();
  two.saw(two.b);
  EXPECT_EQ(propose(1).pairs.size(), 1U);
  two.merging.take_back();
  EXPECT_TRUE(propose(1).pairs.empty());
  two.merging.forget(1 + two.options.recent + 1);
  two.merging.remember();
  two.merging.sighted(two.a, 40, 8);  // which alone is no pair: it is the earlier of the two
  two.merging.sighted(two.b, 40, 8);
  two.merging.take_back();
  two.merging.sighted(two.a, 40, 8);
  EXPECT_TRUE(propose(40).pairs.empty());
}

TEST(LandmarkMerging, TwoFarApartAreTwo) {
  EXPECT_TRUE(Two({1.5, 0}).propose().pairs.empty());
}

TEST(LandmarkMerging, TwoOfOtherClassesAreTwo) {
  EXPECT_TRUE(Two({0.1, 0.05}, kCar).propose().pairs.empty());
}

TEST(LandmarkMerging, TwoSeenInOneFrameAreTwo) {
  Two two({0.1, 0.05});
  Contribution out;
  const int frame = ++two.world.frames;
  two.world.tracks.attach(two.world.see({10, 0}, kTree, frame), two.a, false, out);
  two.world.tracks.attach(two.world.see({10.1, 0.05}, kTree, frame), two.b, false, out);
  two.world.apply(out);
  EXPECT_TRUE(two.propose().pairs.empty());
}

// Where landmarks are dense, two near each other say less.
TEST(LandmarkMerging, WhatIsPoorlyKnownIsNotMergedWhereLandmarksAreDense) {
  Two two({0.1, 0.05});
  two.world.sigma = 0.5;
  EXPECT_TRUE(
      two.merging.propose(two.world.map(), two.world.classes, 1.0, 1, false, two.world.tracks)
          .pairs.empty());
}

// Where many looks found nothing else, a landmark born later is a copy of one that is known.
TEST(LandmarkMerging, WhatWasBornWhereLittleWasLeftToFindIsMergedEvenIfPoorlyKnown) {
  Two two({0.1, 0.05});
  two.world.sigma = 0.5;
  const auto proposed = [&] {
    two.saw(two.b);
    return two.merging.propose(two.world.map(), two.world.classes, 1.0, 1, false, two.world.tracks);
  };
  EXPECT_TRUE(proposed().pairs.empty());
  two.world.tracks.track(two.b).undetected = 1e-3;
  EXPECT_EQ(proposed().pairs.size(), 1U);
}

TEST(LandmarkMerging, ARefusedMergeIsProposedAgainOnlyOnceMoreIsSeen) {
  Two two({0.1, 0.05});
  const Merge merge = two.propose();
  ASSERT_EQ(merge.pairs.size(), 1U);
  two.merging.refuse(merge, two.world.tracks);
  two.saw(two.a);
  EXPECT_TRUE(two.propose().pairs.empty());
  Contribution out;
  two.world.tracks.attach(two.world.see({10, 0}, kTree), two.a, false, out);
  two.world.apply(out);
  two.merging.sighted(two.a, 1, 1);  // as news
  EXPECT_EQ(two.propose().pairs, merge.pairs);
}

// The newest lies between two that are known to be two.
TEST(LandmarkMerging, ALandmarkThatMayBeEitherOfTwoIsNeither) {
  Two two({0.4, 0});
  Contribution out;
  const int frame = ++two.world.frames;
  two.world.tracks.attach(two.world.see({10, 0}, kTree, frame), two.a, false, out);
  two.world.tracks.attach(two.world.see({10.4, 0}, kTree, frame), two.b, false, out);
  two.world.apply(out);
  EXPECT_TRUE(two.propose().pairs.empty());
  const int c = two.world.landmark({10.2, 0}, kTree, 4);
  two.saw(c);
  EXPECT_TRUE(two.propose().pairs.empty());
  Two clear({0.4, 0});
  clear.saw(clear.world.landmark({10.45, 0.02}, kTree, 4));  // nearer to one of them
  EXPECT_FALSE(clear.propose().pairs.empty());
}

/// What is proposed at the end of the log, when a sensor at the origin has looked from each pose.
Merge proposed_by_misses(Two& two, double max_range = 20) {
  SensorCoverage coverage;
  coverage.max_range = max_range;
  coverage.fov_yaw = 2 * M_PI;
  Views views;
  for (int i = 1; i <= two.world.frames; ++i) {
    const Key pose(key_letter::kPose, static_cast<std::uint64_t>(i));
    if (!two.world.values.contains(pose)) two.world.values.insert(pose, SE2());
    views.add({pose, Eigen::Isometry3d::Identity(), {}}, Eigen::Isometry3d::Identity(), coverage,
              two.world.map());
  }
  for (const int t : {two.a, two.b}) two.world.tracks.track(t).existence = 3;
  return two.merging.propose_by_misses(two.world.map(), two.world.classes, kDensity, views,
                                       two.world.tracks);
}

/// One more sighting of the first landmark, after those of the second.
void see_first_again(Two& two) {
  Contribution out;
  const int frame = ++two.world.frames;
  two.world.tracks.attach(two.world.see({10, 0}, kTree, frame), two.a, false, out);
  two.world.apply(out);
}

TEST(LandmarkMerging, AtTheEndTwoOfWhichEachLookSeesOneAreOne) {
  Two two({0.5, 0});
  see_first_again(two);
  EXPECT_TRUE(two.propose().pairs.empty());  // where they are does not tell
  const Merge merge = proposed_by_misses(two);
  ASSERT_EQ(merge.pairs.size(), 1U);
  EXPECT_EQ(merge.pairs[0], std::make_pair(two.b, two.a));
  EXPECT_GT(merge.evidence, std::log(two.options.merge_odds));
}

/// Of a merge of two that were seen in one frame once, with so many times the variance.
double evidence_beside(double noise) {
  Two two({0.5, 0});
  for (int i = 0; i < 20; ++i) see_first_again(two);
  two.world.noise = noise;
  Contribution out;
  const int frame = ++two.world.frames;
  two.world.tracks.attach(two.world.see({10, 0}, kTree, frame), two.a, false, out);
  two.world.tracks.attach(two.world.see({10.5, 0}, kTree, frame), two.b, false, out);
  two.world.apply(out);
  const Merge merge = proposed_by_misses(two);
  EXPECT_EQ(merge.pairs.size(), 1U);
  return merge.evidence;
}

// What is taken for clutter is compared with a sighting, whose density falls as the noise grows:
// the evidence does not depend on the units of ranges and angles.
TEST(LandmarkMerging, ASightingBesideIsClutterTheMoreEasilyTheLessIsKnownOfIt) {
  EXPECT_NEAR(evidence_beside(100) - evidence_beside(1), std::log(100), 1e-6);
}

/// Drift may have brought the second over the first: whether a place is seen again, loops decide.
TEST(LandmarkMerging, AtTheEndTwoOfDifferentStretchesOfTheWayStayTwo) {
  Two two({0.5, 0});
  EXPECT_TRUE(proposed_by_misses(two).pairs.empty());
}

TEST(LandmarkMerging, AtTheEndTwoThatNoLookHadInViewStayTwo) {
  Two two({0.5, 0});
  see_first_again(two);
  EXPECT_TRUE(proposed_by_misses(two, 9).pairs.empty());
}

TEST(LandmarkMerging, AtTheEndTwoSeenInOneFrameAreOneOnlyIfTheRestOutweighsTheClutter) {
  const auto pairs = [](int apart, int together) {
    Two two({0.1, 0});
    for (int i = 0; i < apart + together; ++i) {
      Contribution out;
      const int frame = ++two.world.frames;
      if (i < together || i % 2 == 0) {
        two.world.tracks.attach(two.world.see({10, 0}, kTree, frame), two.a, false, out);
      }
      if (i < together || i % 2 == 1) {
        two.world.tracks.attach(two.world.see({10.1, 0}, kTree, frame), two.b, false, out);
      }
      two.world.apply(out);
    }
    return proposed_by_misses(two).pairs.size();
  };
  EXPECT_EQ(pairs(20, 1), 1U);
  EXPECT_EQ(pairs(0, 10), 0U);
}

TEST(LandmarkMerging, AtTheEndWhatIsTentativeIsNoLandmarkToMergeWith) {
  Two two({0.1, 0});
  see_first_again(two);
  two.options.confirm = 5;
  two.merging = LandmarkMerging(two.options);
  EXPECT_TRUE(proposed_by_misses(two).pairs.empty());
}

TEST(LandmarkMerging, AtTheEndLandmarksThatTheSensorNamesOrThatWereKnownStay) {
  Two named({0.5, 0});
  see_first_again(named);
  for (const int s : named.world.tracks.track(named.b).sightings) {
    named.world.tracks.sighting(s).detection.id = 7;
  }
  EXPECT_TRUE(proposed_by_misses(named).pairs.empty());
  named.options.use_ids = false;
  named.merging = LandmarkMerging(named.options);
  EXPECT_EQ(proposed_by_misses(named).pairs.size(), 1U);
  named.world.tracks.track(named.b).known_sightings = 3;
  EXPECT_TRUE(proposed_by_misses(named).pairs.empty());
}

/// What counting proposes about three landmarks at one place, each pair of which eight looks show.
/// The third lies between the others and looks like `class_of_third`; `all` looks show all three.
Merge proposed_by_counting(int all, const std::vector<double>& class_of_third = kTree) {
  Two two({0.3, 0});
  const int c = two.world.landmark({10.15, 0}, class_of_third, 1);
  const std::vector<std::pair<int, double>> landmarks = {{two.a, 10}, {two.b, 10.3}, {c, 10.15}};
  for (int i = 0; i < 24 + all; ++i) {
    Contribution out;
    const int frame = ++two.world.frames;
    for (int k = 0; k < 3; ++k) {
      if (i < 24 && i % 3 == k) continue;
      const auto& [t, x] = landmarks[static_cast<std::size_t>(k)];
      const auto& seen_as = k == 2 ? class_of_third : kTree;
      two.world.tracks.attach(two.world.see({x, 0}, seen_as, frame), t, false, out);
    }
    two.world.apply(out);
  }
  two.world.tracks.track(c).existence = 3;
  EXPECT_TRUE(proposed_by_misses(two).pairs.empty());  // of no pair does each look see one
  SensorCoverage coverage;
  coverage.max_range = 20;
  coverage.fov_yaw = 2 * M_PI;
  Views views;
  for (int i = 1; i <= two.world.frames; ++i) {
    views.add(
        {Key(key_letter::kPose, static_cast<std::uint64_t>(i)), Eigen::Isometry3d::Identity(), {}},
        Eigen::Isometry3d::Identity(), coverage, two.world.map());
  }
  return two.merging.propose_by_counting(two.world.map(), two.world.classes, views,
                                         two.world.tracks);
}

TEST(LandmarkMerging, AtTheEndThreeOfWhichEachLookSeesTwoAreTwo) {
  const Merge merge = proposed_by_counting(0);
  ASSERT_EQ(merge.pairs.size(), 1U);
  EXPECT_GT(merge.evidence, std::log(AssociationOptions().merge_odds));
  EXPECT_TRUE(proposed_by_counting(24).pairs.empty());
}

// A few sightings of another class may be misread, many are not.
TEST(LandmarkMerging, AtTheEndClassesSpeakAgainstWhatIsSpared) {
  const double same = proposed_by_counting(0).evidence;
  EXPECT_LT(proposed_by_counting(0, {0.4, 0.6}).evidence, same);
}

}  // namespace
}  // namespace hybrid
