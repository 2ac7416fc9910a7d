// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/health/run_health.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "tests/mrpt_plugins/health/judged_walk.h"

namespace hybrid {
namespace {

using namespace testing;

const HealthEntry* find(const Health& health, const std::string& name) {
  for (const HealthEntry& entry : health) {
    if (entry.name == name) return &entry;
  }
  return nullptr;
}

HealthVerdict verdict_of(const Health& health, const std::string& name) {
  const HealthEntry* entry = find(health, name);
  if (entry == nullptr) {
    ADD_FAILURE() << "no entry " << name;
    return HealthVerdict::kGood;
  }
  EXPECT_FALSE(entry->sentence.empty()) << name;
  EXPECT_EQ(entry->knob.empty(), entry->verdict == HealthVerdict::kGood) << name;
  return entry->verdict;
}

Stated stated(double range, double move) {
  Stated s;
  s.range = range;
  s.move = move;
  return s;
}

TEST(RunHealth, IsGoodWhereAllIsAsStated) {
  const Health health = Walk({}).health();
  EXPECT_GE(health.size(), 5U);
  for (const HealthEntry& entry : health) {
    EXPECT_EQ(entry.verdict, HealthVerdict::kGood) << entry.name << " " << entry.value;
  }
  EXPECT_NEAR(find(health, "noise of ranges of detections")->value, 1, 0.2);
  EXPECT_NEAR(find(health, "path against odometry")->value, 1, 0.3);
}

TEST(RunHealth, NoiseOfRangesThatIsStatedWrongly) {
  const char* name = "noise of ranges of detections";
  EXPECT_EQ(verdict_of(Walk(stated(0.25, 1)).health(), name), HealthVerdict::kBad);
  EXPECT_EQ(verdict_of(Walk(stated(0.57, 1)).health(), name), HealthVerdict::kDoubtful);
  EXPECT_EQ(verdict_of(Walk(stated(6, 1)).health(), name), HealthVerdict::kDoubtful);
  EXPECT_EQ(verdict_of(Walk(stated(0.25, 1)).health(), "noise of bearings of detections"),
            HealthVerdict::kGood);
}

TEST(RunHealth, OdometryThatIsTooSureOrTooUnsure) {
  const char* name = "path against odometry";
  EXPECT_EQ(verdict_of(Walk(stated(1, 0.25)).health(), name), HealthVerdict::kBad);
  EXPECT_EQ(verdict_of(Walk(stated(1, 10)).health(), name), HealthVerdict::kBad);
  EXPECT_EQ(verdict_of(Walk(stated(1, 2)).health(), name), HealthVerdict::kGood);
}

TEST(RunHealth, APathByScansThatAgreesOverTimeMayDepartFromOdometry) {
  const char* name = "path against odometry";
  Stated s = stated(1, 0.25);
  s.by_scans = true;
  EXPECT_EQ(verdict_of(Walk(s).health_by_scans(true), name), HealthVerdict::kDoubtful);
  EXPECT_EQ(verdict_of(Walk(s).health_by_scans(false), name), HealthVerdict::kBad);
}

TEST(RunHealth, OdometryThatIsCalibratedIsComparedAsItsCalibrationHasIt) {
  const char* name = "path against odometry";
  Stated s;
  s.calibrated = true;
  const Health health = Walk(s).health();
  EXPECT_EQ(verdict_of(health, name), HealthVerdict::kGood);
  EXPECT_NEAR(find(health, name)->value, 1, 0.3);
  s.move = 0.25;
  EXPECT_EQ(verdict_of(Walk(s).health(), name), HealthVerdict::kBad);
}

TEST(RunHealth, CopiesAreLandmarksBesideOthersThatAreNeverSeenWithThem) {
  Stated s;
  s.copies = true;
  const Health health = Walk(s).health();
  EXPECT_EQ(verdict_of(health, "copies of landmarks"), HealthVerdict::kBad);
  EXPECT_NEAR(find(health, "copies of landmarks")->value, 0.5, 1e-9);
  EXPECT_EQ(find(Walk(s).health(0), "copies of landmarks"), nullptr);  // ids tell them apart
}

// Nothing is seen twice, so that all agrees with everything.
TEST(RunHealth, IdsThatNeverReturnAreBad) {
  const char* name = "ids seen again";
  EXPECT_EQ(verdict_of(Walk({}).health(0), name), HealthVerdict::kGood);
  Stated s;
  s.own_ids = true;
  EXPECT_EQ(verdict_of(Walk(s).health(0), name), HealthVerdict::kBad);
  EXPECT_EQ(find(Walk({}).health(), name), nullptr);  // the mapping decided
}

TEST(RunHealth, LandmarksThatAreHardlySeenWhenInView) {
  Stated s;
  s.seen = 8;
  EXPECT_EQ(verdict_of(Walk(s).health(), "landmarks seen when in view"), HealthVerdict::kBad);
}

// Lasers and receivers make keyframes of their own.
TEST(RunHealth, KeyframesOfOtherSensorsMissNothingAndHaveNoClockOfDetections) {
  Stated s;
  s.every = 8;
  const Health health = Walk(s).health();
  EXPECT_EQ(verdict_of(health, "landmarks seen when in view"), HealthVerdict::kGood);
  EXPECT_EQ(verdict_of(health, "landmarks seen at one time only"), HealthVerdict::kGood);
  s.every = 2;
  EXPECT_NEAR(find(Walk(s).health(), "clock of the detections")->most, 0.1, 1e-6);
}

/// What a check says of two drives along things: the second is `aside` of the first, and sees all
/// as landmarks of its own.
HealthVerdict verdict_of_two_drives(double aside, const std::string& name) {
  HybridGraph graph;
  Estimate estimate;
  MapResult result;
  graph.emplace<Prior<SE2>>(pose_key(0), SE2(), Noise::isotropic(3, 1e-3));
  for (int i = 0; i < 100; ++i) {
    const SE2 pose(0.4 * (i % 50), i < 50 ? 0 : aside, 0);
    estimate.values.insert(pose_key(i), pose);
    result.trajectory.push_back({0.5 * i, to_mrpt(pose)});
    if (i == 0) continue;
    const SE2 before = estimate.values.at<SE2>(pose_key(i - 1));
    graph.emplace<Between<SE2>>(pose_key(i - 1), pose_key(i), before.between(pose),
                                Noise::isotropic(3, 0.01));
  }
  for (int k = 0; k < 60; ++k) {
    const Eigen::Vector2d at(0.8 * (k % 30) - 2, k < 30 ? 1 : aside - 1);
    bool is_seen = false;
    for (int i = k < 30 ? 0 : 50; i < (k < 30 ? 50 : 100); ++i) {
      const Eigen::Vector2d p = estimate.values.at<SE2>(pose_key(i)).inverse() * at;
      const double yaw = std::atan2(p.y(), p.x());
      if (p.norm() > 6 || std::abs(yaw) > 1) continue;
      graph.emplace<BearingRange<SE2>>(pose_key(i), point_key(k), Eigen::Vector2d(p.norm(), yaw),
                                       Noise::isotropic(2, 0.01), SE2());
      is_seen = true;
    }
    if (!is_seen) continue;
    estimate.values.insert(point_key(k), at);
    result.landmarks.emplace_back();
    result.landmarks.back().id = k;
    result.landmarks.back().position = {at.x(), at.y(), 0};
  }
  const std::map<std::string, std::size_t> none;
  return verdict_of(run_health({graph, estimate, result, none, 1}), name);
}

TEST(RunHealth, LandmarksAreLostWhereWhoStandsWhereTheyWereSeenDoesNotSeeThem) {
  const char* name = "landmarks seen at one time only";
  EXPECT_EQ(verdict_of_two_drives(0.3, name), HealthVerdict::kBad);
  EXPECT_EQ(verdict_of_two_drives(3, name), HealthVerdict::kGood);  // a wall is between
}

// Nothing says what keyframes that have left a bounded window saw; what is left is judged.
TEST(RunHealth, WhatHasLeftTheWindowIsNotMissed) {
  Stated s;
  s.left = kPoses / 2;
  const Health health = Walk(s).health();
  EXPECT_EQ(verdict_of(health, "landmarks seen at one time only"), HealthVerdict::kGood);
  EXPECT_EQ(verdict_of(health, "path against odometry"), HealthVerdict::kGood);
}

TEST(RunHealth, ASensorThatIsTurnedOrLooksBackSeesWhatItHasInView) {
  for (const auto& [turned, aside] :
       {std::pair(M_PI / 2, 0.0), std::pair(0.0, M_PI), std::pair(-2.0, 1.0)}) {
    Stated s;
    s.turned = turned;
    s.aside = aside;
    EXPECT_EQ(verdict_of(Walk(s).health(), "landmarks seen when in view"), HealthVerdict::kGood)
        << turned << " " << aside;
  }
}

TEST(RunHealth, AScaleThatNoOdometryHas) {
  for (const auto& [scale, verdict] :
       {std::pair{1.2, HealthVerdict::kGood}, std::pair{0.6, HealthVerdict::kDoubtful},
        std::pair{0.3, HealthVerdict::kBad}, std::pair{-0.01, HealthVerdict::kBad}}) {
    Walk walk({});
    walk.calibrate(scale);
    const Health health = walk.health();
    EXPECT_EQ(verdict_of(health, "scale of rotation of odometry"), verdict) << scale;
    EXPECT_EQ(verdict_of(health, "scale of translation of odometry"), HealthVerdict::kGood);
  }
}

// Ranges or odometry may be off: a map that agrees over time may have the wrong size.
TEST(RunHealth, AScaleBesideRangesIsNoBetterThanAWheelIs) {
  const char* name = "scale of translation of odometry";
  for (const auto& [scale, alone, agreeing] :
       {std::tuple{0.97, HealthVerdict::kGood, HealthVerdict::kGood},
        std::tuple{0.93, HealthVerdict::kDoubtful, HealthVerdict::kDoubtful},
        std::tuple{1.2, HealthVerdict::kBad, HealthVerdict::kDoubtful},
        std::tuple{3.28, HealthVerdict::kBad, HealthVerdict::kBad}}) {
    Walk walk({});
    walk.calibrate(1, scale);
    EXPECT_EQ(verdict_of(walk.health(), name), alone) << scale;
    EXPECT_EQ(verdict_of(walk.health_that_agrees(), name), agreeing) << scale;
  }
}

TEST(RunHealth, AClockThatIsLate) {
  Stated s;
  s.late = 1;
  const Health health = Walk(s).health();
  EXPECT_EQ(verdict_of(health, "clock of the detections"), HealthVerdict::kBad);
  EXPECT_NEAR(find(health, "clock of the detections")->value, 0.5, 0.2);
}

TEST(RunHealth, SharesOfWhatWasNotUsed) {
  Walk walk({});
  walk.dropped_["detection dropped: its thing moves"] = 300;
  walk.dropped_["detection taken for clutter: its landmark was not seen again"] = 10000;
  const Health health = walk.health();
  EXPECT_EQ(verdict_of(health, "detections without a landmark"), HealthVerdict::kBad);
  EXPECT_EQ(verdict_of(health, "detections of moving things"), HealthVerdict::kGood);
  // Beside those that were used and have left the window, these are few.
  EXPECT_EQ(verdict_of(walk.health(100000), "detections without a landmark"), HealthVerdict::kGood);
}

// The robot may have been carried, or its odometry may have been switched on anew.
TEST(RunHealth, MotionThatIsNotKnownIsDoubtfulWhereNothingAgreesAfterIt) {
  const char* name = "motion that is not known";
  Walk walk({});
  EXPECT_EQ(find(walk.health(), name), nullptr);
  walk.dropped_[kOdometryMissing] = 2;
  EXPECT_EQ(verdict_of(walk.health(), name), HealthVerdict::kDoubtful);
  EXPECT_EQ(find(walk.health(), name)->value, 2);
  EXPECT_EQ(verdict_of(walk.health_by_scans(true), name), HealthVerdict::kGood);
  EXPECT_EQ(verdict_of(walk.health_by_scans(false), name), HealthVerdict::kDoubtful);
  walk.dropped_[kOdometryMissing] = kPoses - 1;  // a log without odometry
  EXPECT_EQ(find(walk.health(), name), nullptr);
}

TEST(RunHealth, OfNextToNothing) {
  HybridGraph graph;
  Estimate estimate;
  MapResult result;
  const std::map<std::string, std::size_t> none;
  EXPECT_TRUE(run_health({graph, estimate, result, none, 1}).empty());
  estimate.values.insert(pose_key(0), SE2());
  result.trajectory.push_back({0, {}});
  graph.emplace<Prior<SE2>>(pose_key(0), SE2(), Noise::isotropic(3, 1e-3));
  EXPECT_TRUE(run_health({graph, estimate, result, none, 1}).empty());
}

TEST(RunHealth, ScansAreJudgedByWhatThePluginsCounted) {
  const HybridGraph graph;
  const Estimate estimate;
  const MapResult result;
  const std::map<std::string, std::size_t> none;
  const auto verdicts = [&](double blind, double lost, double odometry) {
    const Health health = run_health({graph,
                                      estimate,
                                      result,
                                      none,
                                      0,
                                      {{"scans", 1000},
                                       {"scans_blind", blind},
                                       {"scans_lost", lost},
                                       {"odometry_translation_scale", 1},
                                       {"odometry_rotation_scale", odometry}}});
    std::vector<HealthVerdict> out;
    for (const HealthEntry& entry : health) {
      out.push_back(entry.verdict);
      EXPECT_EQ(entry.knob.empty(), entry.verdict == HealthVerdict::kGood) << entry.name;
    }
    return out;
  };
  using Verdicts = std::vector<HealthVerdict>;
  const auto good = HealthVerdict::kGood, bad = HealthVerdict::kBad;
  EXPECT_EQ(verdicts(100, 2, 3), (Verdicts{good, good, good}));
  EXPECT_EQ(verdicts(900, 2, 3), (Verdicts{bad, good, good}));
  EXPECT_EQ(verdicts(100, 100, 3), (Verdicts{good, bad, good}));
  EXPECT_EQ(verdicts(100, 2, 30), (Verdicts{good, good, bad}));
}

TEST(RunHealth, ARobotThatWasCarriedIsToldWhereThePlacesDoNotAgree) {
  const HybridGraph graph;
  const Estimate estimate;
  const MapResult result;
  const std::map<std::string, std::size_t> none;
  const auto said = [&](double times, bool agrees) {
    RunToJudge run{graph, estimate, result, none, 0, {{"scans", 1000}, {"scans_carried", times}}};
    run.agrees = agrees;
    for (const HealthEntry& entry : run_health(run)) {
      if (entry.name == "robot that was carried") return std::make_optional(entry.verdict);
    }
    return std::optional<HealthVerdict>();
  };
  EXPECT_EQ(said(0, false), std::nullopt);
  EXPECT_EQ(said(1, false), HealthVerdict::kDoubtful);
  EXPECT_EQ(said(1, true), HealthVerdict::kGood);
}

}  // namespace
}  // namespace hybrid
