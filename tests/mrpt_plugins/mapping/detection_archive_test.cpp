// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "mrpt_plugins/mapping/detection_archive.h"

#include <gtest/gtest.h>

#include "mrpt_plugins/mapping/backend.h"

namespace hybrid {
namespace {

/// A keyframe 1 m ahead of the one before, whose camera 0.5 m ahead of the robot sees two things.
Keyframe detecting_keyframe(double time) {
  Keyframe out;
  out.time = time;
  out.odometry =
      OdometryIncrement{mrpt::poses::CPose3D(1, 0, 0, 0, 0, 0), Matrix6d::Identity(), true};
  DetectionFrame frame;
  frame.sensor_label = "camera";
  frame.is_3d = false;
  frame.T_robot_sensor.translation().x() = 0.5;
  Detection detection;
  detection.range = 2;
  detection.covariance.diagonal() << 0.01, 0.01, 0;
  frame.detections = {detection, detection};
  frame.detections[1].at_rest = false;
  out.detections.push_back(frame);
  frame.has_range = false;
  out.detections.push_back(frame);
  return out;
}

/// A map of keyframes along the x axis, and their path.
struct Driven {
  explicit Driven(std::size_t count)
      : mapper(MotionOptions(), {}, make_backend(IniFile("", "test.ini").section("solver")),
               false) {
    for (std::size_t i = 0; i < count; ++i) mapper.add(detecting_keyframe(double(i)));
    path = mapper.result().trajectory;
  }
  Mapper mapper;
  Trajectory path;
};

TEST(DetectionArchive, LaysOutWhatMayStandStill) {
  const Driven driven(3);
  DetectionArchive archive;
  for (std::size_t i = 0; i < 3; ++i) archive.add(i, detecting_keyframe(double(i)));
  const std::vector<PlacedDetections> placed = archive.placed(driven.mapper, driven.path);
  ASSERT_EQ(placed.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    const auto keyframe = double(i / 2);
    EXPECT_EQ(placed[i].time, keyframe);
    EXPECT_EQ(placed[i].has_range, i % 2 == 0);
    EXPECT_EQ(placed[i].seen.size(), 1U);
    EXPECT_NEAR(placed[i].T_map_sensor.translation().x(), keyframe + 0.5, 1e-9);
  }
}

TEST(DetectionArchive, KeepsEverySecondFrameBeyondItsBudget) {
  const Driven driven(100);
  DetectionArchive archive(50);
  for (std::size_t i = 0; i < 100; ++i) archive.add(i, detecting_keyframe(double(i)));
  const std::vector<PlacedDetections> placed = archive.placed(driven.mapper, driven.path);
  EXPECT_GE(placed.size(), 13U);
  EXPECT_LE(placed.size(), 25U);
  EXPECT_EQ(placed.front().time, 0);
  EXPECT_GT(placed.back().time, 90);
}

}  // namespace
}  // namespace hybrid
