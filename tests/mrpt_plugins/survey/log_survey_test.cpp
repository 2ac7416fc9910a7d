// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/survey/log_survey.h"

#include <gtest/gtest.h>

#include "mrpt_plugins/bridge/pose_conversions.h"
#include "tests/libhybrid/uncertainty/driven_world.h"

namespace hybrid {
namespace {

DetectionFrame frame_of(const MovedSightings& moved) {
  DetectionFrame out;
  out.time = moved.sightings.time;
  out.sensor_label = "CAMERA";
  out.is_3d = false;
  out.T_robot_sensor = to_isometry(to_mrpt(moved.sightings.T_robot_sensor));
  for (std::size_t k = 0; k < moved.sightings.seen.size(); ++k) {
    const MeasuredPoint& m = moved.sightings.seen[k];
    Detection d;
    d.range = m.z[0];
    d.yaw = m.z[1];
    d.id = moved.ids[k];
    d.covariance.topLeftCorner<2, 2>() = m.covariance;
    out.detections.push_back(d);
  }
  return out;
}

template <class Found = LogFindings>
Found survey(const DrivenWorld& world, const SourceOptions& options = {},
             Found (LogSurvey::*conclude)() const = &LogSurvey::conclude) {
  const DrivenLog log = drive(world);
  LogSurvey survey(options);
  for (std::size_t i = 0; i < log.frames.size(); ++i) {
    LogStep step;
    step.time = log.frames[i].sightings.time;
    if (i > 0) {
      const SE3 motion = log.frames[i - 1].T_odometry_robot.between(log.frames[i].T_odometry_robot);
      step.odometry = OdometryIncrement{to_mrpt(motion), log.frames[i].motion_covariance, true};
    }
    survey.add(step, {frame_of(log.frames[i])});
  }
  return (survey.*conclude)();
}

const NoiseRecord& record(const LogFindings& findings, const std::string& kind) {
  for (const NoiseRecord& r : findings.noise) {
    if (r.kind == kind) return r;
  }
  throw std::runtime_error("no record of " + kind);
}

TEST(LogSurvey, MeasuredNoiseReplacesThatOfTheLogAndIsSaid) {
  DrivenWorld world;
  world.stated_range = 0.5;
  const LogFindings found = survey(world);
  const NoiseRecord& range = record(found, "range");
  EXPECT_NEAR(*range.stated, 0.5, 1e-9);
  EXPECT_NEAR(range.used, world.range_m, 0.2 * world.range_m);
  ASSERT_FALSE(found.remarks.empty());
  EXPECT_NE(found.remarks.front().find("noise of CAMERA range: 0.5 m stated"), std::string::npos)
      << found.remarks.front();

  DetectionFrame frame;
  frame.sensor_label = "CAMERA";
  frame.is_3d = false;
  frame.detections.resize(1);
  frame.detections[0].range = 5;
  frame.detections[0].covariance.diagonal() << 0.25, 0.0004, 0;
  found.correction.correct(0, frame);
  EXPECT_NEAR(std::sqrt(frame.detections[0].covariance(0, 0)), world.range_m, 0.02);
}

TEST(LogSurvey, ASigmaOfTheOptionsGoesFirst) {
  DrivenWorld world;
  world.stated_range = 0.5;
  SourceOptions options;
  options.detections.sigma_range = 0.5;
  const LogFindings found = survey(world, options);
  EXPECT_NEAR(record(found, "range").used, 0.5, 1e-9);
  EXPECT_FALSE(found.correction.sensors.at("CAMERA").range);
  EXPECT_NE(found.remarks.front().find("stated is used"), std::string::npos);
}

TEST(LogSurvey, TellsASignOrUnitThatIsNotAsStatedWithoutUsingIt) {
  DrivenWorld world;
  EXPECT_TRUE(survey(world, {}, &LogSurvey::contradictions).empty());
  world.mirrored = -1;
  const std::vector<AlignmentRecord> found = survey(world, {}, &LogSurvey::contradictions);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found.front().sensor, "CAMERA");
  EXPECT_TRUE(found.front().mirrored);
}

TEST(LogSurvey, MirroredBearingsAreTurnedBack) {
  DrivenWorld world;
  world.mirrored = -1;
  const LogFindings found = survey(world);
  ASSERT_TRUE(found.correction.sensors.at("CAMERA").mirrored);
  EXPECT_TRUE(found.alignment.front().mirrored);
  DetectionFrame frame;
  frame.sensor_label = "CAMERA";
  frame.detections.resize(1);
  frame.detections[0].yaw = 0.4;
  found.correction.correct(0, frame);
  EXPECT_EQ(frame.detections[0].yaw, -0.4);
}

TEST(LogSurvey, ADelayedSensorStandsWhereItWas) {
  DrivenWorld world;
  world.delay = 0.4;
  const LogFindings found = survey(world);
  const double delay = found.correction.sensors.at("CAMERA").delay;
  EXPECT_NEAR(delay, 0.4, 0.06);
  ASSERT_TRUE(found.correction.path);
  DetectionFrame frame;
  frame.sensor_label = "CAMERA";
  found.correction.correct(30, frame);
  EXPECT_NEAR(frame.T_robot_sensor.translation().norm(), world.speed * delay, 0.05);
}

TEST(LogSurvey, IdsOfATrackerAreHidden) {
  DrivenWorld world;
  world.has_ids = true;
  world.frames = 900;
  EXPECT_FALSE(survey(world).correction.hides_ids);
  world.tracker = true;
  const LogFindings found = survey(world);
  EXPECT_TRUE(found.correction.hides_ids);
  EXPECT_NE(found.remarks.back().find("ids do not return"), std::string::npos);
  const LogFindings ids = survey(world, {}, &LogSurvey::conclude_ids);
  EXPECT_TRUE(ids.correction.hides_ids);
  EXPECT_TRUE(ids.noise.empty());
}

// What comes after the first 20,000 frames shows, too.
TEST(LogSurvey, AllOfALongLogIsMeasured) {
  DrivenWorld world;
  world.things = 30;
  world.frames = 500;
  const DrivenLog good = drive(world);
  world.range_m = 0.5;
  const DrivenLog bad = drive(world);
  LogSurvey survey({}, false);
  for (int round = 0; round < 80; ++round) {
    const DrivenLog& log = round < 48 ? good : bad;
    for (std::size_t i = 0; i < log.frames.size(); ++i) {
      LogStep step;
      step.time = 1000 * round + log.frames[i].sightings.time;
      if (i > 0) {
        const SE3 motion =
            log.frames[i - 1].T_odometry_robot.between(log.frames[i].T_odometry_robot);
        step.odometry = OdometryIncrement{to_mrpt(motion), log.frames[i].motion_covariance, true};
      }
      survey.add(step, {frame_of(log.frames[i])});
    }
  }
  const double range = *record(survey.conclude(), "range").measured;
  EXPECT_GT(range, 0.15);
  EXPECT_LT(range, 0.4);
}

// Ids that are given at random make pairs of any two things: that is no noise of a sensor.
TEST(LogSurvey, ANoiseThatNoSensorHasIsNotUsed) {
  DrivenWorld world;
  world.range_m = 4;
  world.stated_range = 0.2;
  const LogFindings found = survey(world);
  const NoiseRecord& range = record(found, "range");
  ASSERT_TRUE(range.measured);
  EXPECT_GT(*range.measured, 10 * world.stated_range);
  EXPECT_EQ(range.used, *range.stated);
  EXPECT_NE(range.why, "");
  EXPECT_TRUE(found.correction.sensors.at("CAMERA").is_none());
  EXPECT_EQ(found.correction.rotation, 1);
  EXPECT_NE(found.remarks.front().find("no sensor has such noise"), std::string::npos);
}

TEST(LogSurvey, NothingToMeasureIsSaid) {
  EXPECT_TRUE(LogSurvey({}).conclude().noise.empty());
  DrivenWorld world;
  world.frames = 1;
  const LogFindings found = survey(world);
  EXPECT_NE(record(found, "range").why, "");
  EXPECT_EQ(record(found, "range").used, *record(found, "range").stated);
}

}  // namespace
}  // namespace hybrid
