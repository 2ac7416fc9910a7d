// SPDX-License-Identifier: BSD-3-Clause
// Copyright (c) 2026, the hybrid mapping authors

#include "libhybrid/detections/detection_tracker.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "libhybrid/detections/sighting.h"
#include "libhybrid/geometry/isometry.h"
#include "libhybrid/geometry/polar.h"

namespace hybrid {
namespace {

constexpr int kFrames = 10;
constexpr double kSigma = 0.1;  // [m], [rad] a tenth of it

/// A robot that drives ahead, turning, and sees points from a sensor in front.
struct Drive {
  bool is_3d = false;
  std::mt19937 random{7};
  Eigen::Isometry3d T_robot_sensor = to_isometry(SE2(0.5, 0.1, 0.2));
  Eigen::Isometry3d step = to_isometry(SE2(0.5, 0, 0.02));

  double gauss(double sigma) { return sigma * std::normal_distribution<double>()(random); }

  static SE3::Jacobian motion_covariance() {
    SE3::Tangent variances;
    variances << 1e-6, 1e-6, 1e-6, 1e-8, 1e-8, 1e-8;
    return variances.asDiagonal();
  }

  DetectionFrame frame() const {
    DetectionFrame out;
    out.sensor_label = "CAMERA";
    out.T_robot_sensor = T_robot_sensor;
    out.is_3d = is_3d;
    out.max_range = 30;
    return out;
  }

  Detection seen(const Eigen::Isometry3d& T_map_robot, const Eigen::Vector3d& p) {
    const Eigen::Vector3d z =
        to_polar(Eigen::Vector3d(compose(T_map_robot, T_robot_sensor).inverse() * p));
    Detection d;
    d.range = z[0] + gauss(kSigma);
    d.yaw = z[1] + gauss(0.1 * kSigma);
    d.pitch = is_3d ? z[2] + gauss(0.1 * kSigma) : 0;
    d.covariance.diagonal() << kSigma * kSigma, 0.01 * kSigma * kSigma,
        is_3d ? 0.01 * kSigma * kSigma : 0;
    return d;
  }
};

TEST(DetectionTracker, AThingIsHandedOnOnce) {
  for (const bool is_3d : {false, true}) {
    Drive drive{is_3d};
    const Eigen::Vector3d near(9, 3, is_3d ? 1 : 0), far(14, -2, is_3d ? 2 : 0);
    DetectionTracker tracker;
    Eigen::Isometry3d robot = Eigen::Isometry3d::Identity();
    for (int i = 0; i < kFrames; ++i) {
      if (i > 0) {
        tracker.move(drive.step, Drive::motion_covariance());
        robot = compose(robot, drive.step);
      }
      DetectionFrame frame = drive.frame();
      frame.detections = {drive.seen(robot, near), drive.seen(robot, far)};
      if (i % 2 == 1) std::swap(frame.detections[0], frame.detections[1]);
      frame.detections[0].true_id = i % 2;
      frame.detections[1].true_id = 1 - i % 2;
      tracker.take(frame);
    }
    const std::vector<DetectionFrame> out = tracker.release();
    ASSERT_EQ(out.size(), 1U);
    EXPECT_GT(out[0].max_range, 30);
    ASSERT_EQ(out[0].detections.size(), 2U);
    for (std::size_t k = 0; k < 2; ++k) {
      const Detection& d = out[0].detections[k];
      EXPECT_EQ(d.members.size(), static_cast<std::size_t>(kFrames));
      for (const auto& id : d.members) EXPECT_EQ(*id, static_cast<std::int64_t>(k));
      EXPECT_FALSE(d.velocity);  // without times
      const Eigen::Vector3d p = sighted_point(robot, out[0], d);
      EXPECT_LT((p - (k == 0 ? near : far)).norm(), 3 * kSigma);
      // A quarter of the variance is common to all.
      EXPECT_NEAR(d.covariance(0, 0) / (kSigma * kSigma), 0.25 + 0.75 / kFrames, 0.15);
    }
    EXPECT_TRUE(tracker.release().empty());
  }
}

TEST(DetectionTracker, VelocitiesAreThoseOfTheThings) {
  Drive drive;
  DetectionTracker tracker;
  Eigen::Isometry3d robot = Eigen::Isometry3d::Identity();
  for (int i = 0; i < kFrames; ++i) {
    if (i > 0) {
      tracker.move(drive.step, Drive::motion_covariance());
      robot = compose(robot, drive.step);
    }
    DetectionFrame frame = drive.frame();
    frame.time = 50 + 0.1 * i;
    frame.detections = {drive.seen(robot, {12, 4, 0}), drive.seen(robot, {10, 0.05 * i, 0})};
    tracker.take(frame);
  }
  const std::vector<DetectionFrame> out = tracker.release();
  ASSERT_GE(out[0].detections.size(), 2U);
  EXPECT_EQ(out[0].time, 50);
  // In the frame of the sensor as it stands at first, when the robot was at the origin.
  const Eigen::Matrix3d R = drive.T_robot_sensor.linear();
  for (const Detection& d : out[0].detections) {
    if (d.members.size() < kFewestForMotion) continue;  // the second one may be lost in between
    ASSERT_TRUE(d.velocity);
    const bool stands = &d == &out[0].detections.front();
    const Eigen::Vector3d error = R * d.velocity->mean - Eigen::Vector3d(0, stands ? 0 : 0.5, 0);
    const Eigen::Matrix3d P = R * d.velocity->covariance * R.transpose();
    EXPECT_LT(error.x() * error.x(), 16 * P(0, 0));
    EXPECT_LT(error.y() * error.y(), 16 * P(1, 1));
    EXPECT_LT(P(1, 1), 0.3 * 0.3);
  }
  EXPECT_EQ(out[0].detections[0].members.size(), static_cast<std::size_t>(kFrames));
  EXPECT_NEAR(out[0].detections[0].delay, 0.1 * (kFrames - 1) / 2, 1e-6);
}

// A clock that goes back may end at the time at which it began.
TEST(DetectionTracker, VelocitiesAreFiniteWhateverTheClockDoes) {
  Drive drive;
  DetectionTracker tracker;
  for (const double time : {50.0, 50.1, 49.9, 50.0}) {
    tracker.move(Eigen::Isometry3d::Identity(), Drive::motion_covariance());
    DetectionFrame frame = drive.frame();
    frame.time = time;
    frame.detections = {drive.seen(Eigen::Isometry3d::Identity(), {12, 4, 0})};
    tracker.take(frame);
  }
  const std::vector<DetectionFrame> out = tracker.release();
  ASSERT_EQ(out[0].detections.size(), 1U);
  ASSERT_TRUE(out[0].detections[0].velocity);
  EXPECT_TRUE(out[0].detections[0].velocity->covariance.allFinite());
}

// A sensor whose classes change has nothing to compare.
TEST(DetectionTracker, ScoresOfAnotherNumberOfClassesSayNothing) {
  Drive drive;
  DetectionTracker tracker;
  for (const std::vector<double>& scores :
       {std::vector<double>{0.1, 0.9}, {0.2, 0.3, 0.5}, {0.9, 0.1}}) {
    DetectionFrame frame = drive.frame();
    frame.detections = {drive.seen(Eigen::Isometry3d::Identity(), {12, 4, 0})};
    frame.detections[0].class_probabilities = scores;
    tracker.take(frame);
  }
  const std::vector<DetectionFrame> out = tracker.release();
  ASSERT_EQ(out[0].detections.size(), 1U);
  EXPECT_EQ(out[0].detections[0].members.size(), 3U);
}

// However near two things with ids are, each keeps its own.
TEST(DetectionTracker, IdsDecide) {
  Drive drive;
  DetectionTracker tracker;
  for (int i = 0; i < 4; ++i) {
    DetectionFrame frame = drive.frame();
    frame.detections = {drive.seen(Eigen::Isometry3d::Identity(), {10, 0, 0}),
                        drive.seen(Eigen::Isometry3d::Identity(), {10, 0.05, 0})};
    frame.detections[0].id = i % 2 == 0 ? 5 : 6;
    frame.detections[1].id = i % 2 == 0 ? 6 : 5;
    tracker.take(frame);
  }
  const std::vector<Detection> out = tracker.release().at(0).detections;
  ASSERT_EQ(out.size(), 2U);
  EXPECT_EQ(out[0].id, 5);
  EXPECT_EQ(out[1].id, 6);
  EXPECT_EQ(out[0].members.size(), 4U);
}

TEST(DetectionTracker, ClassScoresOfAllCount) {
  Drive drive;
  DetectionTracker tracker;
  for (int i = 0; i < 8; ++i) {
    DetectionFrame frame = drive.frame();
    frame.class_names = {"car", "van"};
    frame.detections = {drive.seen(Eigen::Isometry3d::Identity(), {10, 0, 0})};
    frame.detections[0].class_probabilities = {0.7, 0.3};
    tracker.take(frame);
  }
  const std::vector<double> p = tracker.release().at(0).detections.at(0).class_probabilities;
  EXPECT_GT(p.at(0), 0.9);   // more certain than one alone,
  EXPECT_LT(p.at(0), 0.97);  // less than eight that know nothing of each other
  EXPECT_NEAR(p.at(0) + p.at(1), 1, 1e-12);
}

// The motion of the robot moves what was seen, and its noise is that of the motion.
TEST(DetectionTracker, TheNoiseOfTheMotionSinceIsAdded) {
  for (const double sigma : {0.0, 0.5}) {
    Drive drive;
    DetectionTracker tracker;
    DetectionFrame frame = drive.frame();
    frame.detections = {drive.seen(Eigen::Isometry3d::Identity(), {10, 0, 0})};
    const Detection alone = frame.detections[0];
    tracker.take(frame);
    SE3::Jacobian covariance = SE3::Jacobian::Zero();
    covariance(0, 0) = covariance(1, 1) = sigma * sigma;
    tracker.move(drive.step, covariance);
    const DetectionFrame out = tracker.release().at(0);
    const Detection& d = out.detections.at(0);
    EXPECT_NEAR(d.range, alone.range, 1e-9);
    EXPECT_NEAR(d.yaw, alone.yaw, 1e-9);
    EXPECT_TRUE(out.T_robot_sensor.isApprox(between(drive.step, drive.T_robot_sensor), 1e-12));
    EXPECT_NEAR(d.covariance(0, 0), kSigma * kSigma + sigma * sigma, 1e-9);
  }
}

// Twice as many keyframes do not make the same detections tell more: the side from which a thing is
// seen does not change with them.
TEST(DetectionTracker, DetectionsTellTheSameHoweverManyKeyframesThereAre) {
  const auto information = [](int frames_of_a_keyframe) {
    Drive drive;
    drive.step = to_isometry(SE2(0.1, 0, 0));
    DetectionTrackerOptions options;
    options.lasts = 4;
    DetectionTracker tracker(options);
    double sum = 0;
    Eigen::Isometry3d robot = Eigen::Isometry3d::Identity();
    constexpr int kCount = 80;  // of frames, at 10 Hz
    for (int i = 0; i < kCount; ++i) {
      tracker.move(drive.step, SE3::Jacobian::Zero());
      robot = compose(robot, drive.step);
      DetectionFrame frame = drive.frame();
      frame.time = 0.1 * i;
      frame.detections = {drive.seen(robot, {100, 3, 0})};
      frame.detections[0].id = 1;
      tracker.take(frame);
      if ((i + 1) % frames_of_a_keyframe != 0) continue;
      const std::vector<DetectionFrame> released = tracker.release();
      for (const Detection& d : released.at(0).detections) sum += 1 / d.covariance(0, 0);
    }
    return sum;
  };
  const double few = information(40);
  for (const int frames : {1, 5, 10, 20}) EXPECT_NEAR(information(frames) / few, 1, 0.15) << frames;
}

TEST(DetectionTracker, SensorsAreFollowedApart) {
  Drive drive;
  DetectionTracker tracker;
  for (const char* label : {"LEFT", "RIGHT", "LEFT"}) {
    DetectionFrame frame = drive.frame();
    frame.sensor_label = label;
    frame.detections = {drive.seen(Eigen::Isometry3d::Identity(), {10, 0, 0})};
    tracker.take(frame);
  }
  const std::vector<DetectionFrame> out = tracker.release();
  ASSERT_EQ(out.size(), 2U);
  EXPECT_EQ(out[0].detections.at(0).members.size(), 2U);
  EXPECT_EQ(out[1].detections.at(0).members.size(), 1U);
}

TEST(DetectionTracker, WhatIsForgottenIsCounted) {
  Drive drive;
  DetectionTracker tracker;
  DetectionFrame frame = drive.frame();
  frame.detections = {drive.seen(Eigen::Isometry3d::Identity(), {10, 0, 0}),
                      drive.seen(Eigen::Isometry3d::Identity(), {5, 5, 0})};
  tracker.take(frame);
  tracker.take(frame);
  EXPECT_EQ(tracker.forget(), 4U);
  EXPECT_TRUE(tracker.release().empty());
}

}  // namespace
}  // namespace hybrid
