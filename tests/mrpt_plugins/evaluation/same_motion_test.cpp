// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/evaluation/same_motion.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace hybrid {
namespace {

using mrpt::poses::CPose3D;

constexpr TruthContent kBoth[] = {TruthContent::kPoses, TruthContent::kPositions};

/// A drive of speeds and turns that change now and then, and how odometry tells it.
struct Drive {
  explicit Drive(unsigned seed, std::size_t poses = 300, double noise = 0.05) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    double speed = 1, turn = 0;
    truth.emplace_back();
    told.emplace_back();
    for (std::size_t i = 1; i < poses; ++i) {
      if (i % 15 == 0) {
        speed = std::abs(1 + 0.5 * normal(random));
        turn = 0.15 * normal(random);
      }
      truth.push_back(truth.back() + CPose3D(speed, 0, 0, turn, 0, 0));
      told.push_back(told.back() + CPose3D(speed * (1 + noise * normal(random)), 0, 0,
                                           turn + 0.2 * noise * normal(random), 0, 0));
    }
  }
  std::vector<CPose3D> truth, told;
};

std::vector<PosePair> pairs(const std::vector<CPose3D>& told, const std::vector<CPose3D>& truth) {
  std::vector<PosePair> out;
  for (std::size_t i = 0; i < told.size(); ++i) out.push_back({told[i], truth[i]});
  return out;
}

TEST(SameMotion, OfItsOwnTruthIsSeen) {
  for (unsigned seed = 0; seed < 40; ++seed) {
    for (const double noise : {0.0, 0.05, 0.2}) {
      const Drive drive(seed, 300, noise);
      for (const TruthContent content : kBoth) {
        EXPECT_TRUE(may_be_same_motion(pairs(drive.told, drive.truth), content)) << seed;
      }
    }
  }
}

TEST(SameMotion, OfAnotherDriveIsNot) {
  int rejected[2] = {0, 0};
  for (unsigned seed = 0; seed < 40; ++seed) {
    const Drive drive(seed), other(seed + 100);
    for (const TruthContent content : kBoth) {
      const bool may_be = may_be_same_motion(pairs(drive.told, other.truth), content);
      rejected[content == TruthContent::kPoses ? 0 : 1] += may_be ? 0 : 1;
    }
  }
  EXPECT_GE(rejected[0], 36);
  EXPECT_GE(rejected[1], 25);
}

TEST(SameMotion, ThatNeverChangesTellsNothing) {
  std::vector<CPose3D> told, truth;
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    told.emplace_back(i + 0.02 * normal(random), 0.02 * normal(random), 0, 0, 0, 0);
    truth.emplace_back(1.02 * i + 0.02 * normal(random), 0.02 * normal(random), 0, 0, 0, 0);
  }
  for (const TruthContent content : kBoth) {
    EXPECT_TRUE(may_be_same_motion(pairs(told, truth), content));
    EXPECT_TRUE(may_be_same_motion({}, content));
    const std::vector<CPose3D> still(200);
    EXPECT_TRUE(may_be_same_motion(pairs(still, still), content));
  }
}

// A receiver's fixes scatter by more than the robot moves from one to the next.
TEST(SameMotion, IsSeenInFixesOfAReceiver) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Drive drive(seed);
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0, 1);
    std::vector<CPose3D> fixes;
    for (const CPose3D& pose : drive.truth) {
      fixes.emplace_back(pose.x() + normal(random), pose.y() + normal(random), 0, 0, 0, 0);
    }
    EXPECT_TRUE(may_be_same_motion(pairs(drive.told, fixes), TruthContent::kPositions)) << seed;
  }
}

}  // namespace
}  // namespace hybrid
