// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/frame_association.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "tests/libhybrid/landmarks/track_graph.h"

namespace hybrid {
namespace {

using testing::kCar;
using testing::kTree;
using testing::TrackGraph;
using Method = AssociationOptions::Method;

/// What a frame seen from the origin may be.
struct Look {
  TrackGraph world;
  AssociationOptions options;
  SensorCoverage coverage;
  Views views;
  Key recent_since{key_letter::kPose, 0};  // with which the last stretch of the way begins
  std::vector<std::vector<double>> phi;
  DetectionFrame frame;

  Look() {
    frame.is_3d = false;
    frame.max_range = 30;
    frame.fov_yaw = 2 * M_PI;
    coverage.learn(frame);
  }
  void detect(const Eigen::Vector2d& point, const std::vector<double>& scores = {}) {
    Detection d;
    d.range = point.norm();
    d.yaw = std::atan2(point.y(), point.x());
    d.covariance.diagonal() << 0.01, 1e-4, 0;
    frame.detections.push_back(d);
    phi.push_back(scores);
  }
  FrameCandidates candidates() {
    const std::vector<DetectionFrame> frames = {frame};
    const KeyframeView view = world.keyframe(Key(key_letter::kPose, 1000), frames);
    return find_candidates(view, frame, phi, world.map(),
                           {options, coverage, world.classes, views, recent_since, world.tracks});
  }
  std::vector<FrameHypothesis> hypotheses() { return find_hypotheses(candidates(), options); }
};

TEST(FrameAssociation, ADetectionOnALandmarkIsItAndOneFarFromAllIsNew) {
  for (const Method method : {Method::kHypotheses, Method::kNearest, Method::kJcbb}) {
    Look look;
    look.options.method = method;
    const int a = look.world.landmark({10, 0}), b = look.world.landmark({0, 12});
    look.detect({0.05, 12.1});
    look.detect({-9, -3});
    look.detect({10.1, 0.05});
    const auto found = look.hypotheses();
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].track, (std::vector<int>{b, -1, a}));
  }
}

TEST(FrameAssociation, EachLandmarkHasItsOwnExtent) {
  for (const Method method : {Method::kHypotheses, Method::kJcbb}) {
    Look look;
    look.options.method = method;
    look.options.extent = {0.5};
    const int wide = look.world.landmark({10, 0}), sharp = look.world.landmark({0, 12});
    look.world.tracks.set(wide, &Track::extent, 0.5);
    look.detect({10.9, 0});
    look.detect({0, 12.9});
    const auto found = look.hypotheses();
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].track, (std::vector<int>{wide, -1}));
    const FrameCandidates c = look.candidates();
    ASSERT_EQ(c.tracks, (std::vector<int>{wide, sharp}));
    EXPECT_NEAR(c.score(0, 0).chi_square, 0.9 * 0.9 / (0.02 + 0.25), 0.05);
    EXPECT_NEAR(c.score(1, 1).chi_square, 0.9 * 0.9 / 0.02, 5);
  }
}

TEST(FrameAssociation, WhereManyLooksFoundNothingADetectionIsOfWhatIsKnown) {
  // 2.9 sigma from the landmark: as likely a new one where nobody looked.
  Look look;
  const int known = look.world.landmark({10, 0});
  look.world.sigma = 0.3;
  look.detect({10.92, 0});
  const double before = look.candidates().problem.unmatched[0];
  for (std::uint64_t i = 0; i < 12; ++i) {
    const Key pose(key_letter::kPose, 500 + i);
    look.world.values.insert(pose, SE2());
    look.views.add({pose, Eigen::Isometry3d::Identity(), {}}, Eigen::Isometry3d::Identity(),
                   look.coverage, look.world.map());
  }
  look.views.add({Key(key_letter::kPose, 1000), Eigen::Isometry3d::Identity(), {}},
                 Eigen::Isometry3d::Identity(), look.coverage, look.world.map());
  const FrameCandidates after = look.candidates();
  ASSERT_EQ(after.tracks, std::vector<int>{known});
  // What is left is clutter: 0.5 in view, where 5 landmarks and 0.5 of clutter were expected.
  EXPECT_NEAR(after.problem.unmatched[0] - before, std::log(5.5 / 0.5), 0.1);
}

TEST(FrameAssociation, CandidatesAreThoseWithinTheGate) {
  Look look;
  const int near = look.world.landmark({10, 0.2});
  look.world.landmark({10, 5});
  look.world.landmark({-10, 0});
  look.detect({10, 0});
  EXPECT_EQ(look.candidates().tracks, std::vector<int>{near});
}

// Its factors may still be in the graph, and itself among the values.
TEST(FrameAssociation, ALandmarkThatWasGivenUpIsNoCandidate) {
  Look look;
  const int a = look.world.landmark({10, 0}), b = look.world.landmark({10, 0.1});
  look.detect({10, 0});
  ASSERT_EQ(look.candidates().tracks, (std::vector<int>{a, b}));
  Contribution out;
  look.world.tracks.retire(a, out);
  EXPECT_EQ(out.forgotten, std::vector<std::int64_t>{a});
  EXPECT_EQ(look.candidates().tracks, std::vector<int>{b});
  look.world.tracks.track(b).alive = false;  // and still in the grid
  EXPECT_TRUE(look.candidates().tracks.empty());
}

TEST(FrameAssociation, NoHypothesisTakesALandmarkTwiceAndTheBestComesFirst) {
  std::mt19937 random(2);
  std::normal_distribution<double> noise(0, 0.3);
  std::size_t several = 0;
  for (int round = 0; round < 20; ++round) {
    Look look;
    look.world.sigma = 0.3;
    for (int k = 0; k < 5; ++k) look.world.landmark({8 + 0.5 * k, 0.4 * (k % 2)});
    for (int k = 0; k < 4; ++k) {
      look.detect({8 + 0.5 * k + noise(random), 0.4 * (k % 2) + noise(random)});
    }
    const auto found = look.hypotheses();
    ASSERT_FALSE(found.empty());
    EXPECT_LE(found.size(), static_cast<std::size_t>(look.options.hypotheses));
    several += found.size() > 1 ? 1 : 0;
    for (std::size_t h = 0; h < found.size(); ++h) {
      std::multiset<int> taken(found[h].track.begin(), found[h].track.end());
      taken.erase(-1);
      EXPECT_EQ(std::set<int>(taken.begin(), taken.end()).size(), taken.size());
      EXPECT_GE(found[h].cost, found[std::max<std::size_t>(h, 1) - 1].cost);
      EXPECT_LE(found[h].cost, found[0].cost + std::log(look.options.keep_open_odds));
      for (std::size_t g = 0; g < h; ++g) EXPECT_NE(found[g].track, found[h].track);
    }
  }
  EXPECT_GT(several, 10U);
}

TEST(FrameAssociation, ADetectionBetweenTwoLandmarksStaysOpen) {
  Look look;
  const int a = look.world.landmark({10, 0.15}), b = look.world.landmark({10, -0.15});
  look.detect({10, 0});
  const auto found = look.hypotheses();
  ASSERT_GE(found.size(), 2U);
  const std::set<int> best = {found[0].track[0], found[1].track[0]};
  EXPECT_EQ(best, (std::set<int>{a, b}));
  EXPECT_NEAR(found[0].cost, found[1].cost, 1e-6);
}

TEST(FrameAssociation, ClassesTellTwoLandmarksAtTheSameDistance) {
  for (const bool is_tree : {true, false}) {
    Look look;
    const int a = look.world.landmark({10, 0.15}, kTree, 4);
    const int b = look.world.landmark({10, -0.15}, kCar, 4);
    look.detect({10, 0}, is_tree ? kTree : kCar);
    EXPECT_EQ(look.hypotheses().at(0).track[0], is_tree ? a : b);
  }
}

// The drift of the way back to a landmark makes room for others.
TEST(FrameAssociation, WhereThePoseIsLostALandmarkSeenLongAgoIsNoCandidate) {
  for (const double pose_sigma : {0.01, 2.0}) {
    Look look;
    look.world.pose_sigma = pose_sigma;
    look.world.landmark({10, 0});
    look.detect({10, 0});
    look.recent_since = Key(key_letter::kPose, 999);  // after all that has been seen
    const FrameCandidates c = look.candidates();
    const bool may_match = c.problem.matched.size() > 0 && std::isfinite(c.problem.matched(0, 0));
    EXPECT_EQ(may_match, pose_sigma < 1);
  }
}

// Which matchings are kept open says nothing of which landmarks may be matched.
TEST(FrameAssociation, AnOldLandmarkIsMatchedByOddsOfItsOwn) {
  for (const double keep_open : {1.0, 1e9}) {
    for (const double old_landmark : {10.0, 1e9}) {
      Look look;
      look.options.keep_open_odds = keep_open;
      look.options.old_landmark_odds = old_landmark;
      look.recent_since = Key(key_letter::kPose, 999);
      look.world.landmark({10, 0});
      look.detect({10, 0});
      const FrameCandidates c = look.candidates();
      ASSERT_EQ(c.problem.matched.size(), 1);
      EXPECT_EQ(std::isfinite(c.problem.matched(0, 0)), old_landmark < 100);
    }
  }
}

}  // namespace
}  // namespace hybrid
