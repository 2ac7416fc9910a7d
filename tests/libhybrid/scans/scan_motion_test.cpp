// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/scans/scan_motion.h"

#include <gtest/gtest.h>

#include <random>
#include <vector>

namespace hybrid {
namespace {

/// What a keyframe does: half a metre ahead, or a turn on the spot [rad].
enum class Move { kAhead, kTurn };

constexpr double kTurned = 0.35;

/// The noise of odometry of that scale and drift [rad/m] after many such moves, by exact matches.
OdometryNoise driven(const std::vector<Move>& moves, double scale, double drift) {
  constexpr double kTranslation = 0.01, kRotation = 0.012;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  OdometryNoise noise;
  const UncertainMotion exact{SE2(), 1e-6 * Eigen::Matrix3d::Identity()};
  for (const Move move : moves) {
    const bool ahead = move == Move::kAhead;
    const SE2 motion(ahead ? 0.5 : 0.0, 0.0, ahead ? 0.0 : kTurned);
    const double told = motion.angle() / scale - drift * motion.translation().norm();
    const SE2 stated(motion.x() + kTranslation * normal(random), 0.0,
                     told + kRotation * normal(random));
    const SE2 corrected = noise.corrected(stated);
    noise.compare(stated, corrected, stated.translation().norm(), std::abs(stated.angle()),
                  {motion, exact.covariance});
  }
  return noise;
}

std::vector<Move> one_then_other(Move first, Move second) {
  std::vector<Move> moves(200, first);
  moves.insert(moves.end(), 40, second);
  return moves;
}

TEST(OdometryNoise, LittleMotionTellsNothingOfTheScale) {
  // Errors of odometry would be a motion that the robot did not make: a scale of zero.
  const auto straight = driven(one_then_other(Move::kAhead, Move::kTurn), 1, 0).calibration();
  EXPECT_NEAR(straight[1], 1, 0.03);
  EXPECT_NEAR(straight[2], 0, 0.01);
  const auto turning = driven(one_then_other(Move::kTurn, Move::kAhead), 1, 0).calibration();
  EXPECT_NEAR(turning[0], 1, 0.03);
}

TEST(OdometryNoise, OfARobotThatGoesStraightIsMeasured) {
  const OdometryNoise noise = driven(std::vector<Move>(200, Move::kAhead), 1, 0);
  EXPECT_NEAR(noise.rotation_scale(), 0.012 / 0.0105, 0.3);
}

/// Compares a motion as odometry states it with what a match tells, many times.
OdometryNoise compared(const SE2& stated, const SE2& corrected, double turn, const SE2& match) {
  OdometryNoise noise;
  const UncertainMotion exact{match, 1e-6 * Eigen::Matrix3d::Identity()};
  for (int i = 0; i < 40; ++i) {
    noise.compare(stated, corrected, stated.translation().norm(), turn, exact);
  }
  return noise;
}

TEST(OdometryNoise, HalfTurnsTellNothingOfTheScale) {
  // Of keyframes some way apart: the robot goes about, and one angle is past the jump.
  const SE2 stated(0.5, 0.0, M_PI - 0.02), match(0.5, 0.0, -M_PI + 0.02);
  const auto found = compared(stated, stated, M_PI, match).calibration();
  EXPECT_NEAR(found[1], 1, 1e-12);
  EXPECT_NEAR(found[2], 0, 1e-12);
  // A turn of more than half, of which the angle says the rest the other way.
  const SE2 more(0.0, 0.0, -3.05), matched(0.0, 0.0, -2.95);
  EXPECT_NEAR(compared(more, more, 3.23, matched).calibration()[1], 1, 1e-12);
}

TEST(OdometryNoise, AScaleThatIsNotPositiveIsNotMeasured) {
  const SE2 turn(0.0, 0.0, 1.0), back(0.0, 0.0, -1.0);
  const auto turned = compared(turn, back, 1, back).calibration();
  EXPECT_EQ(turned[1], 1);
  EXPECT_NEAR(turned[2], 0, 1e-12);
  const SE2 ahead(0.5, 0.0, 0.0), behind(-0.5, 0.0, 0.0);
  EXPECT_EQ(compared(ahead, behind, 0, behind).calibration()[0], 1);
}

TEST(OdometryNoise, ScaleAndDriftAreFound) {
  std::vector<Move> moves;
  for (int i = 0; i < 200; ++i) moves.push_back(i % 3 == 0 ? Move::kTurn : Move::kAhead);
  const auto found = driven(moves, 1.1, 0.02).calibration();
  EXPECT_NEAR(found[1], 1.1, 0.03);
  EXPECT_NEAR(found[2], 0.02, 0.006);
}

}  // namespace
}  // namespace hybrid
