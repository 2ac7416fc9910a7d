// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/health/run_health.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>

#include "libhybrid/core/key_letters.h"
#include "libhybrid/factors/bearing_range.h"
#include "libhybrid/factors/between.h"
#include "libhybrid/factors/calibrated_motion.h"
#include "libhybrid/factors/prior.h"
#include "libhybrid/geometry/so2.h"
#include "mrpt_plugins/bridge/pose_conversions.h"
#include "tests/support/random.h"

namespace hybrid {
namespace {

using testing::Random;

constexpr int kPoses = 400, kThings = 12;
constexpr double kScale = 1.2;  // of odometry that is calibrated
constexpr double kRangeSigma = 0.1, kYawSigma = 0.01, kMoveSigma = 0.02, kTurnSigma = 0.01;

/// What is stated wrongly.
struct Stated {
  double range = 1, move = 1;  ///< sigmas, times so much
  bool copies = false;         ///< a second landmark for every second thing
  int late = 0;                ///< keyframes by which the motion lags
  int seen = 1;                ///< one of so many looks sees
  double turned = 0;           ///< yaw of the sensor on the robot, and back in its bearings [rad]
  double aside = 0;            ///< yaw that the sensor looks to [rad]
  bool calibrated = false;     ///< odometry is too short, and calibrated
  bool own_ids = false;        ///< each detection is of a landmark of its own
  bool by_scans = false;       ///< nothing is detected, the poses are known
  int left = 0;                ///< keyframes whose measurements have left the window
};

Key pose_key(int i) {
  return Key(key_letter::kPose, static_cast<std::uint64_t>(i));
}
Key calibration_key() {
  return Key(key_letter::kOdometryCalibration, 0);
}
Key point_key(int k) {
  return Key(key_letter::kLandmark, static_cast<std::uint64_t>(k));
}

/// A robot that turns and speeds up and down among things; everything is where it really is.
class Walk {
 public:
  explicit Walk(const Stated& stated) : random_(7), stated_(stated) {
    place_poses();
    place_things();
    add_motions();
    for (int i = stated.left; i < kPoses; ++i) look_from(i);
  }

  Health health(std::size_t decided = 1) const {
    return run_health({graph_, estimate_, result_, dropped_, decided});
  }

  /// Of a log of scans, whose path agrees over time or was not judged.
  Health health_by_scans(bool agrees) const {
    return run_health({graph_, estimate_, result_, dropped_, 0, {{"scans", 100}}, agrees});
  }

  void calibrate(double scale_of_rotation) {
    CalibrationEstimate odometry{"odometry",
                                 {{"scale of translation", "", 1.01, 0.01, 1},
                                  {"scale of rotation", "", scale_of_rotation, 0.01}}};
    for (auto& entry : odometry.entries) entry.observed = true;
    result_.calibration = {odometry};
  }

  std::map<std::string, std::size_t> dropped_;

 private:
  void place_poses() {
    SE2 pose;
    for (int i = 0; i < kPoses; ++i) {
      estimate_.values.insert(pose_key(i), pose);
      result_.trajectory.push_back({0.5 * i, to_mrpt(pose)});
      pose = pose * SE2::exp(Eigen::Vector3d(0.3 + 0.2 * std::sin(0.3 * i), 0,
                                             0.08 + 0.07 * std::sin(0.23 * i)));
    }
  }
  void place_things() {
    for (int k = 0; k < kThings; ++k) {
      const double a = 2 * M_PI * k / kThings;
      add_landmark(k, {8 * std::cos(a), 4 + 8 * std::sin(a)});
      if (stated_.copies && k % 2 == 0) {
        add_landmark(100 + k, {8.1 * std::cos(a), 4 + 8.1 * std::sin(a)});
      }
    }
  }
  void add_landmark(int id, const Eigen::Vector2d& at) {
    estimate_.values.insert(point_key(id), at);
    LandmarkEstimate landmark;
    landmark.id = id;
    landmark.position = {at.x(), at.y(), 0};
    landmark.class_index = id % 2;
    result_.landmarks.push_back(landmark);
  }
  void add_motions() {
    if (stated_.calibrated) {
      const OdometryCalibration2 calibration(kScale, 1, 0);
      estimate_.values.insert(calibration_key(), calibration);
      graph_.emplace<Prior<Eigen::Vector3d>>(calibration_key(), calibration,
                                             Noise::isotropic(3, 0.01));
    }
    graph_.emplace<Prior<SE2>>(pose_key(stated_.left),
                               estimate_.values.at<SE2>(pose_key(stated_.left)),
                               Noise::isotropic(3, 1e-3));
    const Noise noise =
        Noise::diagonal(Eigen::Vector3d(kMoveSigma, kMoveSigma, kTurnSigma) * stated_.move);
    for (int i = stated_.left; i + 1 < kPoses; ++i) {
      const int from = std::min(i + stated_.late, kPoses - 2);
      const SE2 truth = estimate_.values.at<SE2>(pose_key(from)).inverse() *
                        estimate_.values.at<SE2>(pose_key(from + 1));
      const Eigen::Vector3d error(random_.normal(kMoveSigma), random_.normal(kMoveSigma),
                                  random_.normal(kTurnSigma));
      const SE2 z = truth * SE2::exp(error);
      if (stated_.calibrated) {
        const SE2 measured(z.translation() / kScale, z.rotation());
        graph_.emplace<CalibratedMotion2>(pose_key(i), pose_key(i + 1), calibration_key(), measured,
                                          noise);
      } else {
        graph_.emplace<Between<SE2>>(pose_key(i), pose_key(i + 1), z, noise);
      }
    }
  }
  void look_from(int i) {
    const Noise noise = Noise::diagonal(Eigen::Vector2d(kRangeSigma * stated_.range, kYawSigma));
    const SE2 T = estimate_.values.at<SE2>(pose_key(i));
    const Noise matched = Noise::isotropic(3, kYawSigma);
    if (stated_.by_scans) return void(graph_.emplace<Prior<SE2>>(pose_key(i), T, matched));
    for (int k = 0; k < kThings; ++k) {
      int id = stated_.copies && k % 2 == 0 && i % 2 == 0 ? 100 + k : k;
      const Eigen::Vector2d at = estimate_.values.at<Eigen::Vector2d>(point_key(id));
      const Eigen::Vector2d p = T.inverse() * at;
      const double yaw = std::atan2(p.y(), p.x());
      if (p.norm() > 10 || std::abs(wrap_angle(yaw - stated_.aside)) > 1) continue;
      if (random_.below(stated_.seen) != 0) continue;
      if (stated_.own_ids) add_landmark(id = 1000 + kThings * i + k, at);
      graph_.emplace<BearingRange<SE2>>(
          pose_key(i), point_key(id),
          Eigen::Vector2d(p.norm() + random_.normal(kRangeSigma),
                          wrap_angle(yaw - stated_.turned + random_.normal(kYawSigma))),
          noise, SE2(0, 0, stated_.turned));
    }
  }

  Random random_;
  Stated stated_;
  HybridGraph graph_;
  Estimate estimate_;
  MapResult result_;
};

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

}  // namespace
}  // namespace hybrid
