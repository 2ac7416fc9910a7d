// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/uncertainty/agreement.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include "libhybrid/geometry/isometry.h"
#include "libhybrid/geometry/polar.h"
#include "tests/libhybrid/uncertainty/circling_robot.h"

namespace hybrid {
namespace {

using namespace testing;

TEST(AgreementOverTime, OfDetectionsIsOneForTheRightPathWhateverTheSeed) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Agreement found = agreement_of_detections(detections(2 * kLap, none, seed));
    EXPECT_NEAR(found.ratio, 1, 3 * found.sigma + 0.02) << seed;
    EXPECT_LT(found.sigma, 0.13) << seed;
    EXPECT_GT(found.looks, 1000U) << seed;
    EXPECT_GT(found.judged, 0.7) << seed;
  }
}

TEST(AgreementOverTime, WhatMovesIsNoErrorOfThePath) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    std::vector<PlacedDetections> frames = detections(2 * kLap, none, seed);
    // Half of what is detected drives away at a metre a second.
    for (PlacedDetections& frame : frames) {
      const double moved_by = frame.time - 1.7e9;
      const std::size_t still = frame.seen.size();
      for (std::size_t k = 0; k < still; ++k) {
        Eigen::Vector3d p = frame.T_map_sensor * from_polar(Eigen::Vector3d(
                                                     frame.seen[k].z[0], frame.seen[k].z[1], 0.0));
        p.x() += std::fmod(p.x() * 7 + moved_by + 40, 16.0) - 8;
        Eigen::VectorXd z = to_polar(Eigen::Vector3d(frame.T_map_sensor.inverse() * p)).head<2>();
        if (z[0] < 9 && std::abs(z[1]) < 1.5) frame.seen.push_back({z, frame.seen[k].covariance});
      }
    }
    const Agreement found = agreement_of_detections(frames);
    EXPECT_GT(found.ratio + found.sigma, 0.97) << seed;
  }
}

TEST(AgreementOverTime, OfDetectionsFallsWithTheErrorOfThePath) {
  double before = 0.99;
  for (const double metres : {0.3, 0.6, 1.2}) {
    const Agreement found = agreement_of_detections(detections(2 * kLap, in_second_lap(metres)));
    EXPECT_LT(found.ratio, before - 0.05) << metres;
    before = found.ratio;
  }
  EXPECT_LT(before, 0.6);
}

// So little is found by chance that one share of it says nothing of the other.
TEST(AgreementOverTime, OfAPathThatOdometryBendsWithinSecondsIsNearlyNothing) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    std::vector<PlacedDetections> frames = detections(6 * kLap, none, seed);
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> range(1, 9), angle(-1.5, 1.5);
    for (PlacedDetections& frame : frames) {
      for (int i = 0; i < 4; ++i) {  // false ones
        const Eigen::Vector2d z(range(random), angle(random));
        frame.seen.push_back({z, Eigen::Vector2d(1e-2, 1e-4).asDiagonal()});
      }
      frame.T_map_sensor = to_isometry(true_pose(-0.73 * (frame.time - 1.7e9)));
    }
    const Agreement found = agreement_of_detections(frames);
    EXPECT_LT(found.soon, Agreement::kLeastSoon) << seed;
    EXPECT_LT(found.ratio + found.sigma, 0.8) << seed;
    EXPECT_GT(found.looks, 100U) << seed;
  }
}

TEST(AgreementOverTime, InSpaceIsOneForTheRightPathAndLessForAWrongOne) {
  const Agreement right = agreement_of_detections(detections(2 * kLap, none, 1, true));
  EXPECT_NEAR(right.ratio, 1, 3 * right.sigma + 0.02);
  EXPECT_LT(agreement_of_detections(detections(2 * kLap, in_second_lap(1), 1, true)).ratio, 0.7);
}

/// Detections without their ranges, four times a second.
std::vector<PlacedDetections> directions(const PathError& error, unsigned seed, bool is_3d) {
  std::vector<PlacedDetections> out = detections(3 * kLap, error, seed, is_3d, 0.25);
  for (PlacedDetections& frame : out) {
    frame.has_range = false;
    for (MeasuredPoint& seen : frame.seen) {
      seen.z[0] = 0;
      seen.covariance(0, 0) = 0;
    }
  }
  return out;
}

TEST(AgreementOverTime, OfDirectionsIsOneForTheRightPathAndLessForAWrongOne) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    for (const bool is_3d : {false, true}) {
      const Agreement right = agreement_of_detections(directions(none, seed, is_3d));
      EXPECT_NEAR(right.ratio, 1, 3 * right.sigma + 0.02) << seed << is_3d;
      EXPECT_LT(right.sigma, 0.1) << seed << is_3d;
      EXPECT_GT(right.judged, 0.5) << seed << is_3d;
      const Agreement wrong = agreement_of_detections(directions(in_second_lap(2), seed, is_3d));
      EXPECT_LT(wrong.ratio + wrong.sigma, 0.9) << seed << is_3d;
    }
  }
}

TEST(AgreementOverTime, OfDirectionsIsThatOfTheLogWhereEachComesTwice) {
  std::vector<PlacedDetections> frames = directions(none, 1, false);
  const Agreement once = agreement_of_detections(frames);
  const std::size_t count = frames.size();
  for (std::size_t i = 0; i < count; ++i) frames.push_back(frames[i]);
  EXPECT_NEAR(agreement_of_detections(frames).ratio, once.ratio, 0.08);
}

TEST(AgreementOverTime, IsNotJudgedWhereNothingIsSeenAgain) {
  const Agreement found = agreement_of_detections(detections(0.6 * kLap, none));
  EXPECT_EQ(found.looks, 0U);
  EXPECT_TRUE(found.stretches.empty());
}

TEST(AgreementOverTime, OfNothingOrOfOneDetectionIsNotJudged) {
  EXPECT_EQ(agreement_of_detections({}).looks, 0U);
  std::vector<PlacedDetections> one = detections(2, none);
  one.resize(1);
  one.front().seen.resize(1);
  EXPECT_EQ(agreement_of_detections(one).looks, 0U);
  one.front().seen.clear();
  EXPECT_EQ(agreement_of_detections(one).looks, 0U);
  EXPECT_EQ(agreement_of_scans({}).looks, 0U);
}

TEST(AgreementOverTime, OfAShortLogIsOverHalfOfIt) {
  for (const double error : {0.0, 1.0}) {  // a lap takes 52 s
    std::vector<PlacedDetections> frames = detections(1.75 * kLap, in_second_lap(error));
    for (PlacedDetections& frame : frames) frame.time = 1.7e9 + 0.65 * (frame.time - 1.7e9);
    const Agreement found = agreement_of_detections(frames);
    EXPECT_NEAR(found.far_from, 0.65 * (1.75 * kLap - 1) / 2, 1e-6);
    EXPECT_GT(found.looks, 100U);
    const double at_best = found.ratio + found.sigma;
    EXPECT_EQ(at_best > 0.97, error == 0) << found.ratio;
    EXPECT_EQ(at_best < 0.9, error != 0) << found.ratio;
  }
  EXPECT_EQ(agreement_of_detections(detections(30, none)).far_from, 20);
  EXPECT_EQ(agreement_of_detections(detections(2 * kLap, none)).far_from, 60);
}

TEST(AgreementOverTime, ShowsWhenThePathWentWrong) {
  // right in the first two laps, 2 m off in the last
  const PathError error = [](double time) { return Eigen::Vector2d(time < 2 * kLap ? 0 : 2, 0); };
  const Agreement found = agreement_of_detections(detections(3 * kLap, error));
  double early = 0, late = 0;
  for (const Agreement::Stretch& stretch : found.stretches) {
    (stretch.time < 1.7e9 + 2 * kLap ? early : late) += stretch.ratio;
  }
  EXPECT_GT(early / 8, 1.5 * late / 4);
}

TEST(AgreementOverTime, TakesLooksOfAnotherRobotForLate) {
  std::vector<PlacedDetections> both = detections(30, none, 1), other = detections(30, none, 1);
  for (PlacedDetections& frame : other) {
    frame.robot = 1;
    both.push_back(std::move(frame));
  }
  const Agreement found = agreement_of_detections(both);
  EXPECT_GT(found.looks, 100U);
  EXPECT_NEAR(found.ratio, 1, 0.15);
}

TEST(AgreementOverTime, IsTheSameInAnyOrderOfFrames) {
  std::vector<PlacedDetections> frames = detections(2 * kLap, in_second_lap(0.5));
  const double ratio = agreement_of_detections(frames).ratio;
  std::reverse(frames.begin(), frames.end());
  EXPECT_EQ(agreement_of_detections(frames).ratio, ratio);
}

/// Scans of a square room of 24 m with a block in the middle of it, one a second.
std::vector<LaserScan> room_scans(double seconds) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.01);
  std::vector<LaserScan> out;
  for (double time = 0; time < seconds; time += 1) {
    LaserScan scan;
    scan.time = time;
    scan.first_angle = -M_PI / 2;
    scan.angle_step = M_PI / 180;
    const SE2 pose = true_pose(time);
    for (int i = 0; i <= 180; ++i) {
      const double angle = pose.angle() + scan.first_angle + i * scan.angle_step;
      const Eigen::Vector2d d(std::cos(angle), std::sin(angle)), p = pose.translation();
      double range = std::numeric_limits<double>::infinity();
      for (const double half : {12.0, 4.0}) {
        for (int k = 0; k < 2; ++k) {
          for (const double side : {-half, half}) {
            const double t = (side - p[k]) / d[k];
            if (t > 0 && std::abs(p[1 - k] + t * d[1 - k]) <= half) range = std::min(range, t);
          }
        }
      }
      scan.ranges.push_back(static_cast<float>(range + noise(random)));
    }
    out.push_back(std::move(scan));
  }
  return out;
}

Agreement of_scans(const std::vector<LaserScan>& scans, const PathError& error) {
  std::vector<PlacedScan> placed;
  for (const LaserScan& scan : scans) {
    placed.push_back({scan.time, 0, moved(true_pose(scan.time), error(scan.time)), false, &scan});
  }
  return agreement_of_scans(placed);
}

TEST(AgreementOverTime, OfScansIsOneForTheRightPathAndFallsWithItsError) {
  const std::vector<LaserScan> scans = room_scans(2 * kLap);
  const Agreement right = of_scans(scans, none);
  EXPECT_NEAR(right.ratio, 1, 0.02);
  EXPECT_GT(right.judged, 0.8);
  const Agreement off = of_scans(scans, in_second_lap(0.5));
  EXPECT_LT(off.ratio, 0.9);
  EXPECT_LT(of_scans(scans, in_second_lap(2)).ratio, 0.9);
  EXPECT_EQ(of_scans(room_scans(30), none).looks, 0U);
}

/// The walls of the same room, seen from inside, but for some of the block, with a point every
/// 10 cm; moved by a motion.
std::vector<StoredScans> room_map(const SE2& moved_by, double block_from = -4) {
  StoredScans out;
  out.T_map_anchor.motion = moved_by;
  for (const double half : {12.0, 4.0}) {
    for (double along = -half; along <= half; along += 0.1) {
      if (half < 5 && along < block_from) continue;
      for (const double side : {-1.0, 1.0}) {
        const double towards = half > 5 ? -side : side;  // the robot is between room and block
        SurfacePoint x, y;
        x.position = {side * half, along};
        x.normal = {towards, 0};
        y.position = {along, side * half};
        y.normal = {0, towards};
        out.points.push_back(x);
        out.points.push_back(y);
      }
    }
  }
  return {out};
}

Agreement with_map(const std::vector<LaserScan>& scans, const std::vector<StoredScans>& map) {
  std::vector<PlacedScan> placed;
  for (const LaserScan& scan : scans) {
    placed.push_back({scan.time, 0, true_pose(scan.time), false, &scan});
  }
  return agreement_with_map(placed, map);
}

TEST(AgreementWithMap, IsOneInTheRightPlaceAndLessInAWrongOne) {
  const std::vector<LaserScan> scans = room_scans(kLap);
  const Agreement right = with_map(scans, room_map(SE2()));
  EXPECT_GT(right.looks, 1000U);
  EXPECT_NEAR(right.ratio, 1, 0.03);
  EXPECT_LT(with_map(scans, room_map(SE2(0.5, 0.3, 0))).ratio, 0.75);
  EXPECT_LT(with_map(scans, room_map(SE2(0, 0, 0.1))).ratio, 0.75);
}

TEST(AgreementWithMap, WhatTheMapLacksIsNoErrorOfThePlace) {
  const std::vector<LaserScan> scans = room_scans(kLap);
  EXPECT_NEAR(with_map(scans, room_map(SE2(), 0)).ratio, 1, 0.03);
}

TEST(AgreementWithMap, WithoutSurfacesInViewIsNotJudged) {
  const std::vector<LaserScan> scans = room_scans(kLap);
  EXPECT_EQ(with_map(scans, {}).looks, 0U);
  EXPECT_EQ(with_map(scans, {StoredScans()}).looks, 0U);
  EXPECT_EQ(with_map(scans, room_map(SE2(100, 0, 0))).looks, 0U);
  EXPECT_EQ(with_map({}, room_map(SE2())).looks, 0U);
}

TEST(AgreementOverTime, OfScansTakesRaysOfBothSenses) {
  std::vector<LaserScan> scans = room_scans(2 * kLap);
  for (LaserScan& scan : scans) {
    std::reverse(scan.ranges.begin(), scan.ranges.end());
    scan.first_angle = -scan.first_angle;
    scan.angle_step = -scan.angle_step;
  }
  EXPECT_NEAR(of_scans(scans, none).ratio, 1, 0.02);
}

TEST(AgreementOverTime, OfScansTakesSensorsThatHangUpsideDown) {
  std::vector<LaserScan> scans = room_scans(2 * kLap);
  std::vector<PlacedScan> placed;
  for (LaserScan& scan : scans) {
    scan.first_angle = -scan.first_angle;
    scan.angle_step = -scan.angle_step;
    placed.push_back({scan.time, 0, true_pose(scan.time), true, &scan});
  }
  EXPECT_NEAR(agreement_of_scans(placed).ratio, 1, 0.02);
}

TEST(AgreementOverTime, OfScansWithoutReturnsIsNotJudged) {
  std::vector<LaserScan> scans = room_scans(2 * kLap);
  for (LaserScan& scan : scans) {
    for (float& range : scan.ranges) range = std::numeric_limits<float>::quiet_NaN();
  }
  EXPECT_EQ(of_scans(scans, none).looks, 0U);
}

}  // namespace
}  // namespace hybrid
