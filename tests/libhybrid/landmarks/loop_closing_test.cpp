// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/landmarks/loop_closing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "libhybrid/geometry/polar.h"
#include "libhybrid/landmarks/landmark_mapper.h"

namespace hybrid {
namespace {

constexpr double kReach = 6;    // of the sensor [m]
constexpr double kRadius = 16;  // of the round [m]: far more than what makes a stretch of the way
constexpr int kRound = 100;     // keyframes
constexpr double kSigmaStep = 0.05, kSigmaTurn = 0.02;  // of a step [m], [rad]

struct Thing {
  Eigen::Vector2d point;  // ahead, left of the start [m]
  int kind = 0;
};

/// A place that no turn of it resembles.
const std::vector<Thing> kPlace = {{{0.5, 3.1}, 0},  {{2.4, -2.2}, 1}, {{4.0, 1.2}, 1},
                                   {{5.1, -1.0}, 0}, {{-1.8, 1.5}, 1}, {{3.2, 4.0}, 0}};

/// A robot drives one round, from one place back to it, where it finds `then` instead.
struct Round {
  LandmarkMapper<SE2> mapper;

  static SE2 pose(int i) {
    const double a = 2 * M_PI * i / kRound;
    return {kRadius * std::sin(a), kRadius * (1 - std::cos(a)), a};
  }

  /// With `glances`, it looks once as it leaves and once when it is back.
  explicit Round(const std::vector<Thing>& then, unsigned seed = 1, double drift = 1,
                 bool glances = false) {
    std::mt19937 random(seed);
    const auto noisy = [&](double sigma) {
      return sigma * std::normal_distribution<double>()(random);
    };
    for (int i = 0; i < kRound + 12; ++i) {
      DetectionFrame seen;
      seen.is_3d = false;
      seen.max_range = kReach;
      seen.fov_yaw = 2 * M_PI;
      seen.class_names = {"tree", "car"};
      for (const Thing& thing : i < kRound / 2 ? kPlace : then) {
        const Eigen::Vector2d z = to_polar(Eigen::Vector2d(pose(i).inverse() * thing.point));
        if (z[0] > kReach || (glances && i % kRound != 1)) continue;
        Detection d;
        d.range = z[0] + noisy(0.03);
        d.yaw = z[1] + noisy(0.01);
        d.covariance.diagonal() << 9e-4, 1e-4, 0;
        d.class_probabilities = {thing.kind == 0 ? 0.9 : 0.1, thing.kind == 0 ? 0.1 : 0.9};
        seen.detections.push_back(d);
      }
      const SE2 motion = i == 0 ? SE2()
                                : pose(i - 1).between(pose(i)) * SE2{noisy(drift * kSigmaStep),
                                                                     noisy(drift * kSigmaStep),
                                                                     noisy(drift * kSigmaTurn)};
      const double scale = i == 0 ? 1e-2 : drift;
      mapper.add(motion,
                 Noise::diagonal(scale * Eigen::Vector3d(kSigmaStep, kSigmaStep, kSigmaTurn)),
                 {seen});
    }
    mapper.finish();
  }
  double loops() const {
    const auto statistics = mapper.association().statistics();
    const auto it = statistics.find("loops_closed");
    return it == statistics.end() ? 0 : it->second;
  }
  double error_at(int i) const {
    const SE2 found = mapper.smoother().values().at<SE2>(LandmarkMapper<SE2>::pose_key(i));
    return (found.translation() - pose(i).translation()).norm();
  }
  double error() const { return error_at(static_cast<int>(mapper.keyframes()) - 1); }
};

// Where the drift leaves little choice, landmarks are merged pair by pair: that too moves the map
// by metres, and is right or wrong only once the map has settled.
TEST(LoopClosing, APlaceSeenAgainClosesTheLoop) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Round round(kPlace, seed);
    EXPECT_EQ(round.mapper.landmarks().size(), kPlace.size());
    EXPECT_LT(round.error(), 0.3);
  }
}

TEST(LoopClosing, APlaceFarOffByDriftIsRecognisedAsAWhole) {
  // Of 40 rounds 38 are recognised, and end .20 m off in the median, .44 m at worst.
  int recognised = 0;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    Round round(kPlace, seed, 2.5);
    if (round.loops() == 0) continue;
    ++recognised;
    EXPECT_EQ(round.mapper.landmarks().size(), kPlace.size());
    EXPECT_LT(round.error(), 0.6);
  }
  EXPECT_GE(recognised, 6);
}

TEST(LoopClosing, APlaceOfTentativeLandmarksIsRecognised) {
  for (const unsigned seed : {1U, 2U, 3U}) {
    Round round(kPlace, seed, 2.5, true);
    EXPECT_EQ(round.loops(), 1);
    EXPECT_GE(round.mapper.landmarks().size(), kPlace.size() - 1);
    EXPECT_LT(round.error_at(kRound + 1), 0.3);
  }
}

TEST(LoopClosing, TheMirrorImageOfAPlaceIsAnother) {
  std::vector<Thing> mirrored = kPlace;
  for (Thing& thing : mirrored) thing.point.y() *= -1;
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Round round(mirrored, seed);
    EXPECT_EQ(round.loops(), 0);
    EXPECT_EQ(round.mapper.landmarks().size(), 2 * kPlace.size());
  }
}

TEST(LoopClosing, APlaceOfOtherClassesIsAnother) {
  std::vector<Thing> other = kPlace;
  for (Thing& thing : other) thing.kind = 1 - thing.kind;
  for (const unsigned seed : {1U, 2U, 3U}) {
    const Round round(other, seed);
    EXPECT_EQ(round.loops(), 0);
    EXPECT_EQ(round.mapper.landmarks().size(), 2 * kPlace.size());
  }
}

TEST(LoopClosing, TwoLandmarksAreNoPlace) {
  const Round round({kPlace[0], kPlace[1]});
  EXPECT_EQ(round.loops(), 0);
}

// The last stretch of the way is not told from itself.
TEST(LoopClosing, ARobotAtRestClosesNoLoop) {
  LandmarkMapper<SE2> mapper;
  for (int i = 0; i < 40; ++i) {
    DetectionFrame seen;
    seen.is_3d = false;
    seen.max_range = kReach;
    seen.fov_yaw = 2 * M_PI;
    for (const Thing& thing : kPlace) {
      const Eigen::Vector2d z = to_polar(thing.point);
      Detection d;
      d.range = z[0];
      d.yaw = z[1];
      d.covariance.diagonal() << 9e-4, 1e-4, 0;
      if (z[0] < kReach) seen.detections.push_back(d);
    }
    mapper.add(SE2(), Noise::isotropic(3, 0.01), {seen});
  }
  mapper.finish();
  EXPECT_EQ(mapper.association().statistics().count("loops_closed"), 0U);
  EXPECT_EQ(mapper.landmarks().size(), kPlace.size());
}

}  // namespace
}  // namespace hybrid
