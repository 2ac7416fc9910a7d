// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/input/keyframe_source.h"

#include <gtest/gtest.h>
#include <mrpt/obs/CActionRobotMovement3D.h>

#include "mrpt_plugins/observations/classed_bearing_range.h"
#include "tests/mrpt_plugins/input/log_files.h"

namespace hybrid {
namespace {

CObservationClassedBearingRange::Ptr seen(double time, bool has_pitch, const char* label = "a") {
  auto o = CObservationClassedBearingRange::Create();
  o->timestamp = mrpt::Clock::fromDouble(time);
  o->sensorLabel = label;
  o->has_pitch = has_pitch;
  o->std_range = o->std_yaw = o->std_pitch = 0.1F;
  o->detections.push_back({2, 0.1F, 0, 1, 1, {}});
  return o;
}

bool is_3d(const Objects& objects, Dimension dimension = Dimension::kAuto) {
  const TemporaryFile log("space.rawlog");
  write_log(log.path(), objects);
  SourceOptions options;
  options.dimension = dimension;
  KeyframeSource source(log.path(), options);
  const bool result = source.is_3d();
  std::size_t keyframes = 0;
  while (source.next()) ++keyframes;
  EXPECT_GT(keyframes, 0U);
  return result;
}

/// Frames every second; which of them measure pitch.
Objects planar_motion_and(const std::vector<bool>& has_pitch) {
  Objects objects;
  for (std::size_t i = 0; i < has_pitch.size(); ++i) {
    objects.push_back(frame({seen(static_cast<double>(i), has_pitch[i])}));
    objects.push_back(motion_2d({1, 0, 0}, 0.1));
  }
  return objects;
}

/// Detections of all keyframes of a log, and how many of it were dropped since they are repeated.
std::pair<std::vector<std::size_t>, std::size_t> counts(const Objects& objects) {
  const TemporaryFile log("twice.rawlog");
  write_log(log.path(), objects);
  KeyframeSource source(log.path(), {});
  std::vector<std::size_t> seen_by_keyframe;
  while (const auto keyframe = source.next()) {
    std::size_t count = 0;
    for (const DetectionFrame& frame : keyframe->detections) count += frame.detections.size();
    seen_by_keyframe.push_back(count);
  }
  const auto found = source.dropped().find("detection dropped: the log has it more than once");
  return {seen_by_keyframe, found == source.dropped().end() ? 0 : found->second};
}

TEST(KeyframeSource, ADetectionThatTheLogHasTwiceIsOne) {
  const auto two_things = [](double time) {
    auto out = seen(time, false);
    out->detections.push_back({3, -0.1F, 0, 2, 1, {}});
    return out;
  };
  Objects once, rows, messages, other_sensors;
  for (int i = 0; i < 5; ++i) {
    const double time = i;
    auto doubled = two_things(time);
    for (auto& detection : doubled->detections) {
      detection.landmark_id = mrpt::obs::INVALID_LANDMARK_ID;
    }
    doubled->detections.push_back(doubled->detections[0]);
    doubled->detections.push_back(doubled->detections[1]);
    auto other = two_things(time);
    other->sensorLabel = "b";
    once.push_back(frame({two_things(time)}));
    rows.push_back(frame({doubled}));
    messages.push_back(frame({two_things(time), two_things(time)}));
    other_sensors.push_back(frame({two_things(time), other}));
    for (Objects* log : {&once, &rows, &messages, &other_sensors}) {
      log->push_back(motion_2d({1, 0, 0}, 0.1));
    }
  }
  using Counts = std::vector<std::size_t>;
  EXPECT_EQ(counts(once), std::pair(Counts(5, 2), std::size_t(0)));
  EXPECT_EQ(counts(rows), std::pair(Counts(5, 2), std::size_t(10)));
  EXPECT_EQ(counts(messages), std::pair(Counts(5, 2), std::size_t(10)));
  EXPECT_EQ(counts(other_sensors), std::pair(Counts(5, 4), std::size_t(0)));
}

TEST(KeyframeSource, NoSingleFrameDecidesAboutSpace) {
  for (const std::size_t odd : {0UL, 1UL, 5UL, 19UL}) {
    std::vector<bool> has_pitch(20, false);
    EXPECT_FALSE(is_3d(planar_motion_and(has_pitch)));
    has_pitch[odd] = true;
    EXPECT_FALSE(is_3d(planar_motion_and(has_pitch))) << odd;
    has_pitch.flip();
    EXPECT_TRUE(is_3d(planar_motion_and(has_pitch))) << odd;
  }
}

TEST(KeyframeSource, ASensorOfManyDecides) {
  // A planar sensor in every frame, one that measures pitch in every third.
  Objects objects;
  for (int i = 0; i < 30; ++i) {
    objects.push_back(i % 3 == 0 ? frame({seen(i, false), seen(i, true, "camera")})
                                 : frame({seen(i, false)}));
  }
  EXPECT_TRUE(is_3d(objects));
  EXPECT_FALSE(is_3d(objects, Dimension::kPlane));
  EXPECT_TRUE(is_3d(planar_motion_and({false}), Dimension::kSpace));
}

TEST(KeyframeSource, TiltedSensorsAndMotionInSpaceDecideToo) {
  Objects tilted, flying, still;
  for (int i = 0; i < 10; ++i) {
    const auto o = seen(i, false);
    o->sensor_pose = {0, 0, 0, 0, i == 3 ? 0.0 : 0.1, 0};
    tilted.push_back(frame({o}));
    mrpt::obs::CActionRobotMovement3D action;
    action.poseChange.mean = {1, 0, 0, 0, 0, 0};
    action.poseChange.cov.setDiagonal(6, 0.01);
    if (i > 0) flying.push_back(std::make_shared<mrpt::obs::CActionCollection>(action));
    flying.push_back(frame({seen(i, false)}));
    still.push_back(frame({}));
  }
  EXPECT_TRUE(is_3d(tilted));
  EXPECT_TRUE(is_3d(flying));
  EXPECT_FALSE(is_3d(still));
}

TEST(KeyframeSource, TellsItsShareByStepsWhereTheirNumberIsKnown) {
  const TemporaryFile log("share.rawlog");
  write_log(log.path(), planar_motion_and(std::vector<bool>(8, false)));  // read at once
  SourceOptions options;
  options.dimension = Dimension::kPlane;
  options.steps = 8;
  KeyframeSource source(log.path(), options);
  for (int i = 1; i <= 8; ++i) {
    ASSERT_TRUE(source.next());
    EXPECT_DOUBLE_EQ(source.progress().value(), i / 8.0);
  }
  EXPECT_FALSE(source.next());
  EXPECT_DOUBLE_EQ(source.progress().value(), 1.0);
}

}  // namespace
}  // namespace hybrid
